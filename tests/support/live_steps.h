// live_steps.h: what tests of live sources do over and over: open one, step it, wait for an outcome, read why one does not start.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "daemon/core/clock.h"
#include "daemon/sources/live.h"
#include "ipc/outlet.h"

namespace vdisp {

class LiveSteps : public testing::Test {
 protected:
  /// Takes the source's place, and opens it.
  void open(std::unique_ptr<StereoSource> source) {
    source_ = std::move(source);
    images_.clear(), outlets_.clear();
    for (const ImageSpec& spec : source_->open()) {
      outlets_.push_back(std::make_unique<BufferOutlet>(spec));
      images_.push_back(&outlets_.back()->loan());
    }
  }
  Outcome step() {
    while (!source_->wait(100)) {
    }
    for (Image* image : images_) Image::make(image, ImageSpec(image->spec));
    return source_->grab(images_);
  }
  /// Steps until it is `wanted`, at most some seconds.
  bool until(Outcome wanted) {
    const int64_t end = monotonic_ns() + 10'000'000'000;
    while (monotonic_ns() < end)
      if (step() == wanted) return true;
    return false;
  }
  /// The line with which `start` fails, by this exit code.
  template <class Start>
  std::string refusal_of(int code, Start start) {
    try {
      start();
    } catch (const SourceError& error) {
      EXPECT_EQ(error.exit_code, code) << error.what();
      return error.what();
    }
    ADD_FAILURE() << "it started";
    return {};
  }

  Config config_;
  std::unique_ptr<StereoSource> source_;
  std::vector<std::unique_ptr<BufferOutlet>> outlets_;
  std::vector<Image*> images_;
};

}  // namespace vdisp
