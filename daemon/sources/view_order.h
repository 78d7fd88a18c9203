// view_order.h: which of two views is the left one, from the images alone.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "ipc/image.h"

namespace vdisp {

/// What is near lies farther to the right in the left view. Windows with texture are looked for in the other view to both sides at a
/// quarter of the size, where rows that are not rectified yet are near enough; each that matches well on one side alone is a vote.
/// SVS had a button for this, and drivers of the STH-MDCS2 disagree (byte order).
class ViewOrder {
 public:
  static constexpr int shrink = 4, longest_reach = 24, window = 9;  ///< px, of the small views but for shrink
  static constexpr int votes_needed = 150;
  static constexpr double share_needed = 0.8;

  /// Of views of this size. Throws std::bad_alloc.
  void prepare(const ImageSpec& spec);
  /// One more pair. True: the first is the left one; false: the second is; empty: not known yet.
  std::optional<bool> see(const Image& first, const Image& second) noexcept;
  /// Votes for the first and for the second view.
  const std::array<int64_t, 2>& votes() const { return votes_; }

 private:
  struct Small {
    int width = 0, height = 0;
    std::vector<uint8_t> pixels;
    int at(int x, int y) const { return pixels[static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)]; }
  };
  static void make_small(const Image& view, Small& small) noexcept;
  int vote(int x, int y) const noexcept;
  int difference(int x, int y, int shift) const noexcept;

  int reach_ = longest_reach;  // less in small views, or there would be no window to both sides
  std::array<Small, 2> small_;
  std::array<int64_t, 2> votes_{};
};

}  // namespace vdisp
