// fused_grid.h: evidence for and against an obstacle in each cell of a grid that lies along the odometry's axes and follows the rover.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "daemon/stages/placement.h"
#include "ipc/image.h"

namespace vdisp {

/// A square of cells; the ground stays in its cells while the grid moves over it by whole cells. Cells are numbered along the odometry's
/// x ("ahead") and against its y ("right"), floor(x / cell) and floor(-y / cell). Evidence is a logarithm of odds: above 0 for an obstacle.
class FusedGrid {
 public:
  static constexpr float most = 3.0f, least = -1.5f;      ///< so that what changed is believed after three frames, and two
  static constexpr float occupied = 0.62f, free = -0.4f;  ///< evidence from which on a cell is told as such
  static constexpr int slack = 8;                         ///< cells that the rover may be off the middle before the grid follows

  enum class Kind : uint8_t { none, obstacle, drop_off };

  /// `reach`: m from the rover to the border at least.
  void reserve(double reach, double cell);
  int side() const { return side_; }
  void clear() noexcept;
  /// As reserve() left it.
  void begin_anew() noexcept;
  /// Moves the grid where the rover left its middle.
  void follow(const OnGround& rover) noexcept;
  /// All evidence becomes less, by this factor.
  void fade(float factor) noexcept;

  int first_ahead() const { return ahead_; }
  int first_right() const { return right_; }
  /// Of a point; may lie outside.
  int row(double x) const { return ahead_ + side_ - 1 - static_cast<int>(std::floor(x / cell_)); }
  int column(double y) const { return static_cast<int>(std::floor(-y / cell_)) - right_; }
  bool holds(int row, int column) const { return row >= 0 && column >= 0 && row < side_ && column < side_; }
  /// Middle of a cell.
  OnGround middle(int row, int column) const { return {(ahead_ + side_ - 0.5 - row) * cell_, -(right_ + column + 0.5) * cell_}; }

  bool is_obstacle(int row, int column) const {
    return evidence_[index(row, column)] >= occupied && kind_[index(row, column)] == Kind::obstacle;
  }
  bool is_free(int row, int column) const { return evidence_[index(row, column)] <= free; }
  void add(int row, int column, float evidence, Kind kind) noexcept {
    float& e = evidence_[index(row, column)];
    // What is told as occupied keeps its kind: one weak or false vote makes no obstacle of a hole, nor a hole of an obstacle.
    if (kind != Kind::none && e < occupied) kind_[index(row, column)] = kind;
    e = std::clamp(e + evidence, least, most);
  }
  /// 0 to 30 free, 70 to 100 obstacle, in tens, so that a planner is not told of each frame's percent; -1 unknown.
  static int8_t percent(float evidence) noexcept;
  int8_t percent(int row, int column) const noexcept { return percent(evidence_[index(row, column)]); }
  Kind kind(int row, int column) const { return kind_[index(row, column)]; }
  /// A whole row, as it is remembered: percent, and why.
  void tell(int row, int8_t* percents, uint8_t* reasons) const noexcept;

 private:
  size_t index(int row, int column) const { return static_cast<size_t>(row) * static_cast<size_t>(side_) + static_cast<size_t>(column); }
  void move_to(int ahead, int right) noexcept;

  int side_ = 0, ahead_ = 0, right_ = 0;  // cells; numbers of the nearest and leftmost one
  double cell_ = 1;
  std::vector<float> evidence_, moved_evidence_;
  std::vector<Kind> kind_, moved_kind_;
};

}  // namespace vdisp
