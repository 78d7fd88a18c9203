// check.h: how a kernel is tested: the same input at every level of this machine, the whole buffer compared, guard bytes included.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "daemon/kernels/kernels.h"

namespace vdisp::kernels {

/// A picture with guard bytes before, behind and at the end of each row. Rows are not aligned unless asked for. damage() sees what is
/// written into the guard. What is read from it nobody sees, asan neither: it is part of the allocation, a row of it at either end.
template <class T>
class Picture {
 public:
  Picture(int width, int height, int extra_stride = 7, T guard = static_cast<T>(0x5A))
      : width_(width), height_(height), stride_(width + extra_stride), guard_(guard), pixels_(size(), guard) {}

  Plane<T> plane() { return {pixels_.data() + stride_, width_, height_, stride_}; }
  Plane<const T> view() const { return {pixels_.data() + stride_, width_, height_, stride_}; }
  T& at(int x, int y) { return plane().row(y)[x]; }
  /// Where the guard was written over: "" if nowhere.
  std::string damage() const {
    for (size_t i = 0; i < pixels_.size(); ++i) {
      const ptrdiff_t at = static_cast<ptrdiff_t>(i) - stride_;
      const bool inside = at >= 0 && at < stride_ * height_ && at % stride_ < width_;
      if (!inside && pixels_[i] != guard_) return "guard written at offset " + std::to_string(at) + " of stride " + std::to_string(stride_);
    }
    return "";
  }
  bool operator==(const Picture& other) const { return pixels_ == other.pixels_; }

 private:
  size_t size() const { return static_cast<size_t>(stride_) * (height_ + 2); }
  int width_, height_;
  ptrdiff_t stride_;
  T guard_;
  std::vector<T> pixels_;  // one row of guard before and one behind
};

/// What an image may hold that hurts: extremes, edges, repetition, noise.
enum class Content { black, white, checker, ramp, stripes, noise, few_levels };
inline constexpr Content all_contents[] = {Content::black,   Content::white, Content::checker,   Content::ramp,
                                           Content::stripes, Content::noise, Content::few_levels};

template <class T>
void fill(Picture<T>& picture, Content content, uint32_t seed, T most = static_cast<T>(255)) {
  std::minstd_rand random(seed + 1);
  const Plane<T> p = picture.plane();
  for (int y = 0; y < p.height; ++y) {
    for (int x = 0; x < p.width; ++x) {
      const uint32_t noise = static_cast<uint32_t>(random() >> 4);
      uint32_t value = 0;
      switch (content) {
        case Content::black: value = 0; break;
        case Content::white: value = static_cast<uint32_t>(most); break;
        case Content::checker: value = (x + y) % 2 ? static_cast<uint32_t>(most) : 0; break;
        case Content::ramp: value = static_cast<uint32_t>(x * 3 + y) % (static_cast<uint32_t>(most) + 1); break;
        case Content::stripes: value = (x / 3) % 2 ? static_cast<uint32_t>(most) : 0; break;
        case Content::noise: value = noise % (static_cast<uint32_t>(most) + 1); break;
        case Content::few_levels: value = noise % 3 * (static_cast<uint32_t>(most) / 3); break;
      }
      p.row(y)[x] = static_cast<T>(value);
    }
  }
}

/// Widths and heights around the borders of vectors, and single pixels.
inline const std::vector<std::pair<int, int>> awkward_sizes = {{1, 1},  {2, 1},  {1, 5},  {3, 3},  {7, 2},   {15, 4},
                                                               {17, 3}, {33, 5}, {64, 2}, {65, 7}, {127, 3}, {131, 9}};

/// Runs `body(level, kernels)` for every level but plain, with the level in the trace.
template <class Body>
void at_each_level(Body body) {
  for (const std::string& level : levels()) {
    if (level == "plain") continue;
    SCOPED_TRACE("level " + level);
    body(level, kernels(level));
  }
}

}  // namespace vdisp::kernels
