// view_order.cpp: a few hundred windows a pair, sums of absolute differences.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sources/view_order.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace vdisp {
namespace {

constexpr int apart = 5;           // px from window to window
constexpr int least_texture = 12;  // mean step along a row, in 1/4 levels
constexpr int near_zero = 1;       // px: farther than any vote

}  // namespace

void ViewOrder::prepare(const ImageSpec& spec) {
  reach_ = std::clamp((spec.width / shrink - window) / 4, 1, longest_reach);
  for (Small& small : small_) {
    small.width = spec.width / shrink;
    small.height = spec.height / shrink;
    small.pixels.assign(static_cast<size_t>(small.width) * static_cast<size_t>(small.height), 0);
  }
}

void ViewOrder::make_small(const Image& view, Small& small) noexcept {
  for (int y = 0; y < small.height; ++y) {
    for (int x = 0; x < small.width; ++x) {
      int sum = 0;
      for (int v = y * shrink; v < (y + 1) * shrink; ++v)
        for (int u = x * shrink; u < (x + 1) * shrink; ++u) sum += view.row<uint8_t>(v)[u];
      small.pixels[static_cast<size_t>(y) * static_cast<size_t>(small.width) + static_cast<size_t>(x)] =
          static_cast<uint8_t>(sum / (shrink * shrink));
    }
  }
}

/// Mean free: cameras are not equally bright.
int ViewOrder::difference(int x, int y, int shift) const noexcept {
  int mean = 0;
  for (int dy = 0; dy < window; ++dy)
    for (int dx = 0; dx < window; ++dx) mean += small_[0].at(x + dx, y + dy) - small_[1].at(x + dx - shift, y + dy);
  mean /= window * window;
  int sum = 0;
  for (int dy = 0; dy < window; ++dy)
    for (int dx = 0; dx < window; ++dx) sum += std::abs(small_[0].at(x + dx, y + dy) - small_[1].at(x + dx - shift, y + dy) - mean);
  return sum;
}

/// 1: the window of the first view lies farther left in the second one; -1: farther right; 0: no vote.
int ViewOrder::vote(int x, int y) const noexcept {
  int texture = 0;
  for (int dy = 0; dy < window; ++dy)
    for (int dx = 1; dx < window; ++dx) texture += std::abs(small_[0].at(x + dx, y + dy) - small_[0].at(x + dx - 1, y + dy));
  if (4 * texture < least_texture * window * (window - 1)) return 0;
  int best = 0, least = INT32_MAX;
  std::array<int, 2 * longest_reach + 1> differences;
  for (int shift = -reach_; shift <= reach_; ++shift) {
    const int found = differences[static_cast<size_t>(shift + reach_)] = difference(x, y, shift);
    if (found < least) least = found, best = shift;
  }
  if (std::abs(best) <= near_zero) return 0;
  // Nothing elsewhere is nearly as good, and it is good itself.
  for (int shift = -reach_; shift <= reach_; ++shift)
    if (std::abs(shift - best) > 1 && 4 * differences[static_cast<size_t>(shift + reach_)] < 5 * least) return 0;
  if (2 * least > texture) return 0;
  return best > 0 ? 1 : -1;
}

std::optional<bool> ViewOrder::see(const Image& first, const Image& second) noexcept {
  make_small(first, small_[0]);
  make_small(second, small_[1]);
  for (int y = 0; y + window <= small_[0].height; y += apart) {
    for (int x = reach_; x + window + reach_ <= small_[0].width; x += apart) {
      const int found = vote(x, y);
      if (found != 0) ++votes_[found > 0 ? 0 : 1];
    }
  }
  const int64_t all = votes_[0] + votes_[1], most = std::max(votes_[0], votes_[1]);
  if (all < votes_needed || static_cast<double>(most) < share_needed * static_cast<double>(all)) return {};
  return votes_[0] > votes_[1];
}

}  // namespace vdisp
