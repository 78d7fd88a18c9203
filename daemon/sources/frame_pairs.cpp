// frame_pairs.cpp: the newest left frame that has a right one.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sources/frame_pairs.h"

#include <algorithm>
#include <cstdlib>

namespace vdisp {
namespace {

constexpr int refused_until_believed = 10;  // a clock that went back and stays there
constexpr int mismatched_until_anew = 5;    // a camera that counts again from 0

}  // namespace

void FramePairs::give_up(const WaitingFrame& frame) noexcept {
  if (free_count_ < static_cast<int>(free_.size())) free_[static_cast<size_t>(free_count_++)] = frame.slot;
}

int FramePairs::take_free() noexcept { return free_count_ > 0 ? free_[static_cast<size_t>(--free_count_)] : -1; }

void FramePairs::add(int side, const WaitingFrame& frame) noexcept {
  Side& s = sides_[static_cast<size_t>(side)];
  ++tally_.frames[static_cast<size_t>(side)];
  if (s.last && frame.when_ns <= s.last->when_ns) {
    ++tally_.refused[static_cast<size_t>(side)];
    if (++s.refused_in_row < refused_until_believed) return give_up(frame);
    restart(side);
  }
  s.refused_in_row = 0;
  if (s.last) periods_ns_[static_cast<size_t>(side)] = frame.when_ns - s.last->when_ns;
  if (s.size == capacity) drop_until(side, 1, false);
  s.waiting[static_cast<size_t>(s.size++)] = frame;
  s.last = frame;
}

void FramePairs::restart(int side) noexcept {
  Side& s = sides_[static_cast<size_t>(side)];
  drop_until(side, s.size, false);
  s.last.reset();
  s.refused_in_row = 0;
  count_offset_.reset();
  ++tally_.resets;
}

/// The first `number` frames of a side wait no more. The last of them was paired, or none was.
void FramePairs::drop_until(int side, int number, bool pairs_last) noexcept {
  Side& s = sides_[static_cast<size_t>(side)];
  for (int i = 0; i < number; ++i) {
    if (pairs_last && i + 1 == number) break;
    give_up(s.waiting[static_cast<size_t>(i)]);
    ++tally_.unpaired[static_cast<size_t>(side)];
  }
  std::copy(s.waiting.begin() + number, s.waiting.begin() + s.size, s.waiting.begin());
  s.size -= number;
}

bool FramePairs::belong(const WaitingFrame& left, const WaitingFrame& right) noexcept {
  // Never more than half a period apart, whatever the tolerance: the neighbour would be nearer.
  int64_t tolerance = tolerance_ns_;
  for (const int64_t period : periods_ns_)
    if (period > 0) tolerance = std::min(tolerance, period / 2);
  const int64_t apart = std::llabs(right.when_ns - left.when_ns);
  if (by_ == PairBy::time || !count_offset_) return apart <= tolerance;
  return static_cast<int64_t>(right.count - left.count) == *count_offset_;
}

/// How far the nearest right frame that waits is from this left one.
int64_t FramePairs::nearest(const WaitingFrame& left) const noexcept {
  int64_t least = INT64_MAX;
  for (int r = 0; r < sides_[1].size; ++r) {
    const int64_t apart = sides_[1].waiting[static_cast<size_t>(r)].when_ns - left.when_ns;
    if (least == INT64_MAX || std::llabs(apart) < std::llabs(least)) least = apart;
  }
  return least;
}

void FramePairs::measure_apart() noexcept {
  if (sides_[0].size < 2 || sides_[1].size < 2) return;
  const int64_t apart = nearest(sides_[0].waiting[static_cast<size_t>(sides_[0].size - 2)]);
  if (apart != INT64_MAX) apart_ns_ = apart;
}

std::optional<FramePair> FramePairs::take() noexcept {
  for (int l = sides_[0].size - 1; l >= 0; --l) {
    const WaitingFrame left = sides_[0].waiting[static_cast<size_t>(l)];
    int best = -1;
    for (int r = 0; r < sides_[1].size; ++r) {
      const WaitingFrame& right = sides_[1].waiting[static_cast<size_t>(r)];
      const auto apart = [&](int i) { return std::llabs(sides_[1].waiting[static_cast<size_t>(i)].when_ns - left.when_ns); };
      if (belong(left, right) && (best < 0 || apart(r) < apart(best))) best = r;
    }
    if (best < 0) continue;
    const FramePair pair{left, sides_[1].waiting[static_cast<size_t>(best)]};
    if (by_ == PairBy::count) {
      // Equal numbers of neighbouring exposures are a whole period apart: one camera began to count anew. Less is a clock's, not a
      // number's.
      const int64_t period = std::min(periods_ns_[0], periods_ns_[1]), possible_ns = period > 0 ? 3 * period / 4 : 2 * tolerance_ns_;
      const bool possible = std::llabs(pair.right.when_ns - pair.left.when_ns) <= possible_ns;
      mismatched_ = possible ? 0 : mismatched_ + 1;
      count_offset_ = static_cast<int64_t>(pair.right.count - pair.left.count);
      if (mismatched_ >= mismatched_until_anew) {
        restart(0), restart(1);
        mismatched_ = 0;
        return {};
      }
      if (!possible) {
        drop_until(0, l + 1, false);
        drop_until(1, best + 1, false);
        return {};
      }
    }
    drop_until(0, l + 1, true);
    drop_until(1, best + 1, true);
    apart_ns_.reset();
    ++tally_.pairs;
    return pair;
  }
  // All that may wait does, and no two numbers fit: a camera counts anew.
  if (sides_[0].size == capacity && sides_[1].size == capacity) count_offset_.reset();
  measure_apart();
  return {};
}

}  // namespace vdisp
