// fused_grid.cpp: moving by whole cells, fading, and what evidence is told as.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/fused_grid.h"

namespace vdisp {
namespace {

constexpr float all = 255.0f / (FusedGrid::most - FusedGrid::least);  // evidence to an index of Told

/// What each evidence is told as: 256 steps.
struct Told {
  int8_t percent[256];
  uint8_t reason[2][256];  // of an obstacle, of a drop-off

  Told() {
    for (int i = 0; i < 256; ++i) {
      percent[i] = FusedGrid::percent(FusedGrid::least + static_cast<float>(i) / all);
      const bool is = percent[i] >= occupied_from, floor = percent[i] >= 0 && !is;
      const CellReason other = floor ? CellReason::remembered_floor : CellReason::out_of_view;
      reason[0][i] = static_cast<uint8_t>(is ? CellReason::remembered_obstacle : other);
      reason[1][i] = static_cast<uint8_t>(is ? CellReason::remembered_drop_off : other);
    }
  }
};
const Told told;

}  // namespace

int8_t FusedGrid::percent(float evidence) noexcept {
  if (evidence >= occupied) return static_cast<int8_t>(70 + 10 * static_cast<int>(3 * (evidence - occupied) / (most - occupied)));
  if (evidence <= free) return static_cast<int8_t>(10 * static_cast<int>(std::min(3.0f, 4 * (evidence - least) / (free - least))));
  return -1;
}

void FusedGrid::reserve(double reach, double cell) {
  cell_ = cell;
  side_ = 2 * (static_cast<int>(std::ceil(reach / cell)) + slack);
  const size_t cells = static_cast<size_t>(side_) * static_cast<size_t>(side_);
  evidence_.assign(cells, 0);
  kind_.assign(cells, Kind::none);
  moved_evidence_ = evidence_;
  moved_kind_ = kind_;
  ahead_ = right_ = -side_ / 2;
}

void FusedGrid::begin_anew() noexcept {
  clear();
  ahead_ = right_ = -side_ / 2;
}

void FusedGrid::clear() noexcept {
  std::fill(evidence_.begin(), evidence_.end(), 0.0f);
  std::fill(kind_.begin(), kind_.end(), Kind::none);
}

void FusedGrid::follow(const OnGround& rover) noexcept {
  const int ahead = static_cast<int>(std::floor(rover.x / cell_)) - side_ / 2,
            right = static_cast<int>(std::floor(-rover.y / cell_)) - side_ / 2;
  if (std::abs(ahead - ahead_) > slack || std::abs(right - right_) > slack) move_to(ahead, right);
}

void FusedGrid::move_to(int ahead, int right) noexcept {
  const int64_t down = int64_t{ahead} - ahead_, across = int64_t{right} - right_;
  const auto move = [&](auto& from, auto& to, auto nothing) {
    std::fill(to.begin(), to.end(), nothing);
    if (std::abs(down) >= side_ || std::abs(across) >= side_) return;
    const int shift = static_cast<int>(across), first = std::max(0, -shift), last = std::min(side_, side_ - shift);
    for (int row = 0; row < side_; ++row) {
      const int was = row - static_cast<int>(down);
      if (was < 0 || was >= side_) continue;
      std::copy(&from[index(was, first + shift)], &from[index(was, first + shift)] + (last - first), &to[index(row, first)]);
    }
  };
  move(evidence_, moved_evidence_, 0.0f);
  move(kind_, moved_kind_, Kind::none);
  evidence_.swap(moved_evidence_);
  kind_.swap(moved_kind_);
  ahead_ = ahead;
  right_ = right;
}

void FusedGrid::fade(float factor) noexcept {
  constexpr float nothing = 1e-6f;  // smaller ones would become denormal, and slow
  for (float& e : evidence_) e = e * factor * static_cast<float>(e > nothing || e < -nothing);
}

void FusedGrid::tell(int row, int8_t* percents, uint8_t* reasons) const noexcept {
  const float* evidence = &evidence_[index(row, 0)];
  const Kind* kinds = &kind_[index(row, 0)];
  for (int column = 0; column < side_; ++column) {
    const auto step = static_cast<size_t>((evidence[column] - least) * all + 0.5f);
    percents[column] = told.percent[step];
    reasons[column] = told.reason[kinds[column] == Kind::drop_off][step];
  }
}

}  // namespace vdisp
