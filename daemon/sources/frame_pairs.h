// frame_pairs.h: which left frame belongs to which right one.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>

namespace vdisp {

/// One frame that waits for its other half.
struct WaitingFrame {
  int64_t when_ns = 0;  ///< middle of the exposure, CLOCK_MONOTONIC
  uint64_t count = 0;   ///< the camera's own number
  int slot = -1;        ///< where its pixels are
};

struct FramePair {
  WaitingFrame left, right;
};

/// time: frames within the tolerance of each other. count: frames with the same number since both began, which the first pair by time
/// settles; it holds over lost frames, and clocks are only asked whether it can still be true.
enum class PairBy : uint8_t { time, count };

/// Frames of both sides in, pairs out, the newest there is: older frames are never given out after newer ones. Not for several threads.
class FramePairs {
 public:
  static constexpr int capacity = 4;  ///< frames of one side that wait

  struct Tally {
    std::array<uint64_t, 2> frames{}, unpaired{}, refused{};  ///< refused: not newer than the one before
    uint64_t pairs = 0, resets = 0;
  };

  FramePairs(int64_t tolerance_ns, PairBy by) : tolerance_ns_(tolerance_ns), by_(by) {}

  /// Takes a frame of `side` (0 left, 1 right). Slots that are free again come with take_free().
  void add(int side, const WaitingFrame& frame) noexcept;
  /// The newest pair, if there is a new one. What is older waits no more.
  std::optional<FramePair> take() noexcept;
  /// A slot whose frame was given up; -1: none.
  int take_free() noexcept;
  /// Forgets all that waits on one side: its camera began anew.
  void restart(int side) noexcept;

  const Tally& tally() const noexcept { return tally_; }
  /// Least difference of the times of a left and a right frame lately, right after left, where nothing was near enough: how far the two
  /// cameras are apart. Empty as long as pairs are found.
  std::optional<int64_t> apart_ns() const noexcept { return apart_ns_; }

 private:
  struct Side {
    std::array<WaitingFrame, capacity> waiting{};
    int size = 0;
    std::optional<WaitingFrame> last;
    int refused_in_row = 0;
  };
  bool belong(const WaitingFrame& left, const WaitingFrame& right) noexcept;
  void drop_until(int side, int number, bool pairs_last) noexcept;
  void give_up(const WaitingFrame& frame) noexcept;
  void measure_apart() noexcept;
  int64_t nearest(const WaitingFrame& left) const noexcept;

  int64_t tolerance_ns_;
  PairBy by_;
  std::array<Side, 2> sides_;
  std::array<int64_t, 2> periods_ns_{};  // from frame to frame, the last one
  std::optional<int64_t> count_offset_;  // right less left, of frames that belong together
  int mismatched_ = 0;                   // in a row, by count but not by time
  std::array<int, 4 * capacity> free_{};
  int free_count_ = 0;
  std::optional<int64_t> apart_ns_;
  Tally tally_;
};

}  // namespace vdisp
