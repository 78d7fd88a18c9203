// speckle_run.cpp: the three steps of our filter as the stage calls them.
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/speckle_run.h"

#include <cstring>

namespace vdisp::bench {

SpeckleRun::SpeckleRun(const Frames& frames, const Setup& setup)
    : sets_(disparities(frames, 48, Filters::no_speckle)),
      image_(sets_.at(0).at(0)->spec()),
      machine_(setup.config.main.threads, setup.cpu),
      scratch_(image_.spec().width, image_.spec().height) {}

void SpeckleRun::prepare() {
  const Image& from = sets_[++current_ % sets_.size()].at(0)->image();
  std::memcpy(image_.image().row<int16_t>(0), from.row<int16_t>(0), from.spec.bytes() - sizeof(Image));
}

void SpeckleRun::ours() {
  const ImageSpec& spec = image_.spec();
  const kernels::Plane<int16_t> plane{image_.image().row<int16_t>(0), spec.width, spec.height, spec.stride() / 2};
  const kernels::SpeckleRule rule{0, -16, speckle_diff, speckle_size};
  const kernels::Kernels& k = machine_.kernels;
  machine_.bands.run(plane.height, 32, [&](int first, int last, int) { k.speckle_label(plane, rule, first, last, scratch_); });
  k.speckle_join(plane, rule, scratch_);
  machine_.bands.run(plane.height, 32, [&](int first, int last, int) { k.speckle_refuse(rule, first, last, scratch_, plane); });
}

void SpeckleRun::peer() {
  cv::Mat disparity = mat(image_.image(), CV_16S);
  cv::filterSpeckles(disparity, -16, speckle_size, speckle_diff, work_);
}

}  // namespace vdisp::bench
