// occupancy.cpp: obstacles counted by cell, each cell looked up in the image, and both joined; where the ground ends: drop_offs.cpp.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/occupancy.h"

#include <algorithm>
#include <cmath>

#include "daemon/stages/limits_mm.h"

namespace vdisp {
namespace {

constexpr double share_for_e = 0.24;  // pixels seen, of those expected, for 1 - 1 / e, where floor is seen beside them
constexpr double share_alone = 0.06;  // the same where none is
constexpr int occupied = occupied_from;
constexpr int least_weak = 50;                                            // what is less, and not on floor, is not told
constexpr double least_floor = 0.25, least_free = 0.4, sure_floor = 0.6;  // of what a cell shows
constexpr double uneven_of_step = 0.4;  // a cell's floor may be this part of max_height lower than the local floor
constexpr double whole_floor = 0.8;     // of what a cell shows: hardly anything stands before it
constexpr int dark = 14, bright = 250;  // grey levels

/// By the code of a pixel without a disparity.
constexpr auto why_rejected = [] {
  std::array<CellReason, 256> why{};
  why.fill(CellReason::rejected);
  const auto is = [&](Rejected code, CellReason reason) { why[static_cast<size_t>(code)] = reason; };
  is(Rejected::low_texture, CellReason::no_texture);
  is(Rejected::not_unique, CellReason::not_unique);
  is(Rejected::left_right, CellReason::left_right);
  is(Rejected::speckle, CellReason::speckle);
  is(Rejected::outside, CellReason::out_of_view);
  return why;
}();

bool is_untextured(int16_t disparity) { return rejected_code(disparity) == static_cast<uint8_t>(Rejected::low_texture); }

}  // namespace

std::vector<ImageSpec> Occupancy::check(std::span<const ImageSpec> in) {
  if (in.size() != 7)
    throw FormatError("takes disparity, surface, height, obstacles, overhangs, floor model and left view, was given " +
                      std::to_string(in.size()) + " images");
  require(in[0], Pixel::disparity16, "the disparity");
  require(in[1], Pixel::gray8, "the surface");
  require(in[2], Pixel::height16, "the height");
  require(in[3], Pixel::disparity16, "the obstacles");
  require(in[4], Pixel::disparity16, "the overhangs");
  require(in[5], Pixel::record, "the floor model");
  require(in[6], Pixel::gray8, "the left view");
  for (size_t i : {1u, 2u, 3u, 4u, 6u}) require_same_size(in[0], in[i]);
  rows_ = grid_rows(config_);
  columns_ = grid_columns(config_);
  const size_t disparities = 16 * static_cast<size_t>(config_.image_source.ndisp);
  all_limit_.assign(disparities, INT16_MAX);
  obstacles_.assign(static_cast<size_t>(rows_) * static_cast<size_t>(columns_), 0);
  overhangs_ = obstacles_;
  beyond_.assign(obstacles_.size(), Beyond{});
  known_.assign(obstacles_.size(), 0);
  partly_.assign(obstacles_.size(), CellReason::floor);
  whole_ = standing_ = known_;
  edges_.assign(static_cast<size_t>(columns_), -1);
  island_.reserve(obstacles_.size());
  counted_.reserve(obstacles_.size());
  scratch_ = kernels::GroundScratch(in[0].width, static_cast<int>(disparities));
  const ImageSpec grid{Pixel::int8, 0, static_cast<uint16_t>(columns_), static_cast<uint16_t>(rows_)};
  return {grid, {Pixel::gray8, 0, grid.width, grid.height}};
}

Outcome Occupancy::process(std::span<const Image* const> in, std::span<Image* const> out) noexcept {
  const Image& disparity = *in[0];
  const FloorModel& model = *in[5]->row<FloorModel>(0);
  out[0]->reason = no_metres(disparity, model.pitch_rad);
  if (out[0]->reason != Reason::none) return Outcome::invalid;
  const StereoView view = stereo_view(disparity);
  const Inputs inputs{disparity,
                      *in[1],
                      *in[2],
                      *in[6],
                      view,
                      LocalFloor(model, view),
                      {model.pitch_rad, model.roll_rad, model.height_m},
                      ToCamera(model.pitch_rad, model.roll_rad),
                      disparity.camera.min_disparity + disparity.camera.disparities - 1 - view.cx_offset};
  for (Image* image : out) {
    image->grid = grid_geometry(config_, disparity, model.pitch_rad);
    image->flags |= in[5]->flags & flag_held;
  }
  const kernels::Ground ground = ground_of(config_, disparity, model.pitch_rad, model.roll_rad);
  const kernels::Search search = search_of(disparity.camera, static_cast<int>(all_limit_.size()));
  const auto count = [&](const Image& pixels, std::vector<int16_t>& cells) {
    std::fill(cells.begin(), cells.end(), int16_t{0});
    machine_.kernels.count_cells(plane<int16_t>(pixels), search, all_limit_.data(), ground, {cells.data(), columns_, rows_, columns_},
                                 scratch_);
  };
  count(*in[3], obstacles_);
  count(*in[4], overhangs_);
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < columns_; ++column) judge(inputs, row, column, *out[0], *out[1]);
  }
  doubt_lone(inputs, *out[0], *out[1]);
  shade(inputs, *out[0], *out[1]);
  drop_offs(inputs, *out[0], *out[1]);
  join_edges(*out[0], *out[1]);
  refuse_lone_edges(inputs, *out[0], *out[1]);
  extend_edges(*out[0], *out[1]);
  islands(*out[0], *out[1]);
  refuse_partly(*out[0], *out[1]);
  return Outcome::valid;
}

Occupancy::Box Occupancy::box(const Inputs& in, int row, int column) const noexcept {
  const double cell = config_.map.cell, near = (rows_ - 1 - row) * cell, left = (column - columns_ / 2.0) * cell;
  const auto see = [&](double x, double ahead) {
    const double down = in.pose.height - in.floor.elevation(ahead);
    return in.to_camera({x, down, ahead});
  };
  const Point a = see(left, near), b = see(left + cell, near + cell);
  Box box{};
  const double least = 0.05;
  if (a.z < least || b.z < least) return box;
  const double f = in.view.f, fb = f * in.view.baseline;
  const double u0 = in.view.cx + f * a.x / a.z, u1 = in.view.cx + f * b.x / b.z, v0 = in.view.cy + f * a.y / a.z,
               v1 = in.view.cy + f * b.y / b.z;
  // The columns of the middle of the cell, not of its corners, or wide views would look far beside it.
  const double middle_z = (a.z + b.z) / 2, middle_u = (u0 + u1) / 2, half = f * cell / middle_z / 2;
  box = {middle_u - half, middle_u + half, std::min(v0, v1), std::max(v0, v1), fb / b.z, fb / a.z};
  return box;
}

void Occupancy::look(const Inputs& in, const Box& box, Tally& tally) const noexcept {
  const int width = in.disparity.spec.width, rows = in.disparity.spec.height;
  const double left = std::max(box.left, 0.0), right = std::min(box.right, width - 1.0), top = std::max(box.top, 0.0),
               bottom = std::min(box.bottom, rows - 1.0);
  if (!(right > left) || bottom < top || box.d_near <= 0) return;
  const int across = std::clamp(static_cast<int>(right - left), 1, most_samples),
            down = std::clamp(static_cast<int>(bottom - top), 1, most_samples);
  std::array<int, most_samples> columns{};
  for (int i = 0; i < across; ++i) columns[static_cast<size_t>(i)] = static_cast<int>(left + (i + 0.5) * (right - left) / across);
  const double least = 16 * ((1 - depth_share) * box.d_far - depth_off + in.view.cx_offset);
  const double most = 16 * ((1 + depth_share) * box.d_near + depth_off + in.view.cx_offset);
  const int nearest = static_cast<int>(std::floor(most)), farthest = static_cast<int>(std::ceil(least)),
            lowest = static_cast<int>(-1000 * uneven_of_step * config_.limit.max_height);
  const int hole = LimitsMm(config_).hole;
  const auto see_through = [&](Tally::Through& what, int d, int height) {
    const double depth = in.view.f * in.view.baseline / (d / 16.0 - in.view.cx_offset),
                 ahead = (depth - in.pose.height * in.to_camera.sin_pitch) / in.to_camera.cos_pitch;
    ++what.count;
    what.height += height / 1000.0 + in.floor.elevation(ahead);
    what.ahead += ahead;
  };
  for (int j = 0; j < down; ++j) {
    const int v = static_cast<int>(top + (j + 0.5) * (bottom - top) / down);
    const int16_t *d = in.disparity.row<int16_t>(v), *height = in.height.row<int16_t>(v);
    const uint8_t *surface = in.surface.row<uint8_t>(v), *grey = in.left.row<uint8_t>(v);
    for (int i = 0; i < across; ++i) {
      const int u = columns[static_cast<size_t>(i)];
      const auto what = static_cast<kernels::Surface>(surface[u]);
      if (what == kernels::Surface::none) {
        const CellReason why = grey[u] < dark                ? CellReason::too_dark
                               : grey[u] >= bright           ? CellReason::too_bright
                               : height[u] != height_unknown ? CellReason::occluded  // upright, and its foot is hidden
                                                             : why_rejected[rejected_code(d[u])];
        ++tally.why[static_cast<size_t>(why)];
        if (height[u] <= -hole && height[u] != height_unknown && d[u] < farthest) see_through(tally.lower, d[u], height[u]);
      } else if (d[u] > nearest) {
        ++tally.nearer;
      } else if (what == kernels::Surface::floor && d[u] >= farthest && height[u] >= lowest) {
        ++tally.floor;
      } else if (what == kernels::Surface::floor || what == kernels::Surface::below) {
        tally.wall += what == kernels::Surface::below && height[u] > -hole;
        see_through(tally.beyond, d[u], height[u]);
      } else {
        ++tally.why[static_cast<size_t>(CellReason::occluded)];
      }
    }
  }
  tally.all = across * down;
  if (tally.floor > 0) refuse_untextured(in, box, tally);
}

/// The window sees the floor below what has no texture itself: the sky behind a brow, the foot of a blank wall.
void Occupancy::refuse_untextured(const Inputs& in, const Box& box, Tally& tally) const noexcept {
  const double left = std::max(box.left, 0.0), right = std::min(box.right, in.disparity.spec.width - 1.0);
  const double middle = (std::max(box.top, 0.0) + std::min(box.bottom, in.disparity.spec.height - 1.0)) / 2;
  const int16_t* over = in.disparity.row<int16_t>(std::max(static_cast<int>(middle) - config_.image_source.corrsize / 2 - 1, 0));
  int untextured = 0;
  for (const double part : {0.2, 0.5, 0.8}) untextured += is_untextured(over[static_cast<int>(left + part * (right - left))]);
  if (untextured < 2) return;
  tally.why[static_cast<size_t>(CellReason::no_texture)] += tally.floor;
  tally.floor = 0;
}

int Occupancy::seen(int row, int column) const noexcept {
  int sum = 0;
  for (int r = std::max(row - 1, 0); r <= std::min(row + 1, rows_ - 1); ++r) sum += obstacles_[static_cast<size_t>(r * columns_ + column)];
  return sum;
}

void Occupancy::judge(const Inputs& in, int row, int column, Image& occupancy, Image& reason) noexcept {
  int8_t& value = occupancy.row<int8_t>(row)[column];
  uint8_t& why = reason.row<uint8_t>(row)[column];
  const auto say = [&](int is, CellReason because) {
    value = static_cast<int8_t>(is);
    why = static_cast<uint8_t>(because);
  };
  const Box where = box(in, row, column);
  Tally tally;
  look(in, where, tally);
  const size_t cell = static_cast<size_t>(row * columns_ + column);
  beyond_[cell] = {};
  partly_[cell] = CellReason::floor;
  whole_[cell] = tally.floor > whole_floor * std::max(tally.all, 1);
  const int own = obstacles_[cell], around = seen(row, column);
  const double all = std::max(tally.all, 1);
  int risk = 0;
  // Of three cells in a row those that hold a fair part have all of it; one at the rim of an obstacle has what is its own.
  const int counted = 3 * own >= around ? around : own;
  if (own >= config_.map.minCount && where.d_near > 0) {
    // Few pixels that stand where no floor is seen are all there is to see; among floor they may be false.
    const double share = share_alone + (share_for_e - share_alone) * std::min(1.0, tally.floor / all / sure_floor);
    risk = static_cast<int>(100 * (1 - std::exp(-counted / (share * std::max(expected(in, where), 1.0)))));
  }
  if (risk >= occupied) return say(risk, CellReason::obstacle);
  const auto otherwise = [&] {
    std::array<int, cell_reasons> sums = tally.why;
    sums[static_cast<size_t>(CellReason::occluded)] += tally.nearer + static_cast<int>(tally.beyond.count);
    return static_cast<CellReason>(std::max_element(sums.begin(), sums.end()) - sums.begin());
  };
  if (tally.floor >= least_floor * all && tally.all > 0) {
    const int floor = static_cast<int>(free_up_to * (1 - std::min(1.0, tally.floor / all / sure_floor)));
    if (tally.floor < least_free * all) partly_[cell] = otherwise();
    return say(std::max(floor, risk), CellReason::floor);
  }
  if (risk >= least_weak) return say(risk, CellReason::obstacle);
  beyond_[cell] = what_is_beyond(tally);
  if (overhangs_[cell] >= config_.map.minCount && tally.all == 0) return say(-1, CellReason::overhang);
  if (tally.all == 0) return say(-1, CellReason::out_of_view);
  if (where.d_far > in.nearest) return say(-1, CellReason::too_near);
  say(-1, otherwise());
}

}  // namespace vdisp
