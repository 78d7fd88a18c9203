// delayed_image.h: what a stage made of the last frame, kept for a stage that runs before it: IPL's IPLDelayedImage.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstring>
#include <utility>

#include "ipc/outlet.h"

namespace vdisp {

/// A copy, since a published image belongs to the readers. Two buffers, since in one frame the last image may still be read when this
/// frame's is made. All memory is taken by the constructor.
class DelayedImage {
 public:
  explicit DelayedImage(const ImageSpec& spec) : one_(spec), other_(spec) {
    last_->set_blind(Reason::no_last_image);
    next_->set_blind(Reason::no_last_image);
  }

  /// As before the first frame.
  void forget() noexcept {
    for (Image* image : {last_, next_}) Image::make(image, ImageSpec(image->spec))->set_blind(Reason::no_last_image);
    kept_ = false;
  }
  /// Of the last frame. Blind where the stage was, with its reason, and where the stage did not run (no_last_image).
  const Image& last() const { return *last_; }
  /// `image` is of this frame. A blind one is kept without its rows.
  void keep(const Image& image) noexcept {
    std::memcpy(static_cast<void*>(next_), &image, image.valid() ? image.spec.bytes() : sizeof(Image));
    kept_ = true;
  }
  /// The end of a step. A step without a frame leaves everything as it is: the last frame is still the one before.
  void end_step(bool had_frame) noexcept {
    if (had_frame) {
      if (!kept_) Image::make(next_, ImageSpec(next_->spec))->set_blind(Reason::no_last_image);
      std::swap(last_, next_);
    }
    kept_ = false;
  }

 private:
  BufferOutlet one_, other_;
  Image* last_ = &one_.loan();
  Image* next_ = &other_.loan();
  bool kept_ = false;  // in this step
};

}  // namespace vdisp
