// speckle_run.h: our speckle filter and OpenCV's on the same disparities.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/bench/opencv_stages.h"
#include "tests/bench/prepared_tree.h"

namespace vdisp::bench {

/// One disparity image at a time. The filters change it, so that prepare(), which is not timed, goes before each run.
class SpeckleRun {
 public:
  SpeckleRun(const Frames& frames, const Setup& setup);
  /// A fresh copy.
  void prepare();
  void ours();
  void peer();
  const Image* image() { return &image_.image(); }

 private:
  std::vector<Set> sets_;
  size_t current_ = 0;
  Picture image_;
  Machine machine_;
  kernels::SpeckleScratch scratch_;
  cv::Mat work_;
};

}  // namespace vdisp::bench
