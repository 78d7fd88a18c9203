// picture.h: an image with memory of its own, for tests that feed stages by hand.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstring>
#include <functional>

#include "daemon/core/processor.h"
#include "ipc/outlet.h"

namespace vdisp {

class Picture {
 public:
  explicit Picture(const ImageSpec& spec) : outlet_(spec) { std::memset(image().row<uint8_t>(0), 0, spec.bytes() - sizeof(Image)); }
  Picture(Pixel pixel, int width, int height) : Picture(ImageSpec{pixel, 0, static_cast<uint16_t>(width), static_cast<uint16_t>(height)}) {}
  Image& image() { return outlet_.loan(); }
  const ImageSpec& spec() { return image().spec; }
  template <class T>
  T& at(int row, int column) {
    return image().row<T>(row)[column];
  }
  template <class T>
  void fill(const std::function<T(int row, int column)>& value) {
    for (int v = 0; v < spec().height; ++v)
      for (int u = 0; u < spec().width; ++u) at<T>(v, u) = value(v, u);
  }

 private:
  BufferOutlet outlet_;
};

/// Checks formats and runs one frame as the driver would; the outputs have the first input's header.
inline Outcome run_stage(ImageProcessor& stage, std::vector<Picture*> in, std::vector<std::unique_ptr<Picture>>& out) {
  std::vector<ImageSpec> specs;
  std::vector<const Image*> images;
  for (Picture* picture : in) {
    specs.push_back(picture->spec());
    images.push_back(&picture->image());
  }
  out.clear();
  std::vector<Image*> results;
  for (const ImageSpec& spec : stage.check(specs)) {
    out.push_back(std::make_unique<Picture>(spec));
    out.back()->image().describe_like(*images.at(0));
    results.push_back(&out.back()->image());
  }
  return stage.process(images, results);
}

}  // namespace vdisp
