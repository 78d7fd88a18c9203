// raw_pixels.h: the bytes of a camera's frame as gray views: the one copy there is on the way in.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "daemon/sources/camera.h"

namespace vdisp {

/// A view to be written, 8 bits a pixel.
struct GrayView {
  uint8_t* pixels;
  int width, height;
  ptrdiff_t stride;
};

/// Writes what a frame holds: gray as it is, words of more bits by their high 8, the mosaic of a Bayer camera as it is, of colours their
/// luminance (BT.601), of a JPEG its luminance. One for each thread.
class RawPixels {
 public:
  RawPixels();
  ~RawPixels();
  RawPixels(const RawPixels&) = delete;
  RawPixels& operator=(const RawPixels&) = delete;

  /// One view, or left and right. `exchanged`: the first of two views is the right one. False: the frame is too short, damaged or of
  /// another size, and problem() says which; the views may be half written then.
  bool write(const FrameFormat& format, const RawFrame& frame, bool exchanged, std::span<const GrayView> views) noexcept;
  const std::string& problem() const { return problem_; }

 private:
  struct Jpeg;
  bool unpack_jpeg(const FrameFormat& format, const RawFrame& frame) noexcept;

  std::unique_ptr<Jpeg> jpeg_;
  std::string problem_;
};

/// Bytes of one pixel of both views together; 0 for jpeg.
int raw_pixel_bytes(const FrameFormat& format);

}  // namespace vdisp
