// fused_map.cpp: one frame's cells into the grid that remembers.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/fused_map.h"

#include "daemon/stages/ground_grid.h"
#include "ipc/records.h"

namespace vdisp {
namespace {

constexpr float for_obstacle = 1.4f, against = 0.8f;  // evidence of one frame that is sure
constexpr int even = 50;                              // percent that say nothing
// From most to occupied: exp(-keep / t) = occupied / most.
const double fading = std::log(static_cast<double>(FusedGrid::most / FusedGrid::occupied));

bool known(CellReason why) { return why == CellReason::floor || why == CellReason::obstacle || why == CellReason::drop_off; }
/// No ray leads there.
bool out_of_reach(CellReason why) { return why == CellReason::out_of_view || why == CellReason::too_near; }

}  // namespace

std::vector<ImageSpec> FusedMap::check(std::span<const ImageSpec> in) {
  if (in.size() != 5)
    throw FormatError("takes occupancy, reason, disparity, floor model and memory, was given " + std::to_string(in.size()) + " images");
  require(in[0], Pixel::int8, "the occupancy");
  require(in[1], Pixel::gray8, "the reason");
  require_same_size(in[0], in[1]);
  require(in[2], Pixel::disparity16, "the disparity");
  if (in[3] != record_spec<FloorModel>()) throw FormatError("the fourth input is no floor model");
  if (in[4] != record_spec<Memory>()) throw FormatError("the fifth input is no memory");
  rows_ = in[0].height;
  columns_ = in[0].width;
  asked_.assign(static_cast<size_t>(rows_) * static_cast<size_t>(columns_), 0);
  const double corner = std::hypot(config_.map.range, config_.map.width / 2) + std::hypot(config_.mounting.x, config_.mounting.y);
  grid_.reserve(config_.memory.range > 0 ? config_.memory.range : corner, config_.map.cell);
  constexpr int widest = 4096;
  if (grid_.side() > widest)
    throw FormatError("[Memory] range and [Map] cell make " + std::to_string(grid_.side()) + " cells a side, at most " +
                      std::to_string(widest) + " are possible");
  const auto side = static_cast<uint16_t>(grid_.side());
  return {{Pixel::int8, 0, side, side}, {Pixel::gray8, 0, side, side}};
}

void FusedMap::begin_anew() noexcept {
  grid_.begin_anew();
  forgotten_ = 0;
  last_ns_ = 0;
}

Outcome FusedMap::process(std::span<const Image* const> in, std::span<Image* const> out) noexcept {
  const Memory& memory = *in[4]->row<Memory>(0);
  const Frame frame{*in[0], *in[1], Placement(config_.mounting, memory.x, memory.y, memory.yaw)};
  if (memory.forgotten != forgotten_) grid_.clear();
  forgotten_ = memory.forgotten;
  if (memory.state == MemoryState::frame_only) {
    tell_frame(frame, out);
    return Outcome::valid;
  }
  const double passed = std::max(static_cast<double>(frame.occupancy.timestamp_ns - last_ns_) * 1e-9, 0.0);
  last_ns_ = frame.occupancy.timestamp_ns;
  grid_.follow({memory.x, memory.y});
  grid_.fade(static_cast<float>(std::exp(-passed * fading / config_.memory.keep)));
  // As the rover sees the odometry's origin and axes.
  const double c = std::cos(memory.yaw), s = std::sin(memory.yaw);
  for (Image* image : out) {
    GridGeometry& g = image->grid;
    g.frame = grid_of_odometry;
    g.origin_row = static_cast<float>(grid_.first_ahead() + grid_.side());
    g.origin_column = static_cast<float>(-grid_.first_right());
    g.view_left = g.view_right = 0;
    g.pose_x = static_cast<float>(-(c * memory.x + s * memory.y));
    g.pose_y = static_cast<float>(-(c * memory.y - s * memory.x));
    g.pose_yaw = static_cast<float>(-memory.yaw);
    image->flags |= flag_memory;
  }
  SeenThrough rays(config_, *in[2], *in[3]->row<FloorModel>(0));
  fuse(frame, rays, out);
  return Outcome::valid;
}

/// The frame's own cells, the camera in the middle of the grid.
void FusedMap::tell_frame(const Frame& frame, std::span<Image* const> out) const noexcept {
  const int side = grid_.side(), top = side / 2 - rows_, left = side / 2 - columns_ / 2;
  for (Image* image : out) {
    image->grid.origin_row = static_cast<float>(side / 2);
    image->grid.origin_column = static_cast<float>(left) + static_cast<float>(columns_) / 2;
  }
  for (int row = 0; row < side; ++row) {
    int8_t* percents = out[0]->row<int8_t>(row);
    uint8_t* reasons = out[1]->row<uint8_t>(row);
    std::fill_n(percents, side, int8_t{-1});
    std::fill_n(reasons, side, static_cast<uint8_t>(CellReason::out_of_view));
    const int from = row - top;
    if (from < 0 || from >= rows_) continue;
    const int first = std::max(0, -left), last = std::min(columns_, side - left);
    std::copy(frame.occupancy.row<int8_t>(from) + first, frame.occupancy.row<int8_t>(from) + last, percents + left + first);
    std::copy(frame.reason.row<uint8_t>(from) + first, frame.reason.row<uint8_t>(from) + last, reasons + left + first);
  }
}

FusedMap::Window FusedMap::window(const Frame& frame) const noexcept {
  const double range = rows_ * config_.map.cell, half = columns_ * config_.map.cell / 2;
  Window w{grid_.side() - 1, 0, grid_.side() - 1, 0};
  for (const double ahead : {0.0, range}) {
    for (const double right : {-half, half}) {
      const OnGround corner = frame.placement.outside(right, ahead);
      w.top = std::min(w.top, grid_.row(corner.x));
      w.bottom = std::max(w.bottom, grid_.row(corner.x));
      w.left = std::min(w.left, grid_.column(corner.y));
      w.right = std::max(w.right, grid_.column(corner.y));
    }
  }
  return {std::max(w.top, 0), std::min(w.bottom, grid_.side() - 1), std::max(w.left, 0), std::min(w.right, grid_.side() - 1)};
}

void FusedMap::fuse(const Frame& frame, SeenThrough& rays, std::span<Image* const> out) noexcept {
  for (int row = 0; row < grid_.side(); ++row) grid_.tell(row, out[0]->row<int8_t>(row), out[1]->row<uint8_t>(row));
  const Window area = window(frame);
  for (int row = area.top; row <= area.bottom; ++row) {
    for (int column = area.left; column <= area.right; ++column) {
      if (!grid_.is_obstacle(row, column)) continue;
      const OnGround at = grid_.middle(row, column);
      const double right = frame.placement.right(at), ahead = frame.placement.ahead(at);
      if (ahead > 0 && rays.too_near(right, ahead)) rays.hide_behind(right, ahead);
    }
  }
  take(frame, area, rays, out);
  add_missed(frame, out);
}

void FusedMap::take(const Frame& frame, const Window& area, SeenThrough& rays, std::span<Image* const> out) noexcept {
  std::fill(asked_.begin(), asked_.end(), uint8_t{0});
  const double cells = 1 / config_.map.cell, middle = columns_ / 2.0;
  for (int row = area.top; row <= area.bottom; ++row) {
    const OnGround first = grid_.middle(row, area.left);
    double ahead = frame.placement.ahead(first), right = frame.placement.right(first);
    const double more_ahead = -frame.placement.sine() * config_.map.cell, more_right = frame.placement.cosine() * config_.map.cell;
    for (int column = area.left; column <= area.right; ++column, ahead += more_ahead, right += more_right) {
      const double from_near = ahead * cells, from_left = right * cells + middle;
      if (from_near < 0 || from_near >= rows_ || from_left < 0 || from_left >= columns_) continue;
      const int r = rows_ - 1 - static_cast<int>(from_near), c = static_cast<int>(from_left);
      asked_[static_cast<size_t>(r * columns_ + c)] = 1;
      weigh(row, column, frame.occupancy.row<int8_t>(r)[c], CellReason{frame.reason.row<uint8_t>(r)[c]}, {right, ahead}, rays, out);
    }
  }
}

/// One cell, `in_h` its middle: to the right and ahead.
void FusedMap::weigh(int row, int column, int8_t seen, CellReason why, const OnGround& in_h, const SeenThrough& rays,
                     std::span<Image* const> out) noexcept {
  if (seen > free_up_to) return add_obstacle(row, column, seen, why, out);
  const bool remembered = grid_.is_obstacle(row, column);
  const auto believed = [&] { return !rays.too_near(in_h.x, in_h.y) && !rays.hidden(in_h.x, in_h.y); };
  if (seen >= 0) {
    if (remembered && !believed()) return;
    grid_.add(row, column, against * static_cast<float>(seen - even) / even, FusedGrid::Kind::none);
  } else if (remembered && !out_of_reach(why) && believed() && rays.passed(in_h.x, in_h.y)) {
    grid_.add(row, column, -against, FusedGrid::Kind::none);
  }
  const int8_t percent = grid_.percent(row, column);
  out[0]->row<int8_t>(row)[column] = percent;
  uint8_t& reason = out[1]->row<uint8_t>(row)[column];
  // What is told is what was seen in this frame where both agree, or nothing is remembered.
  const bool floor = percent >= 0 && percent < occupied_from;
  if (percent < 0 ? !known(why) : floor && seen >= 0) reason = static_cast<uint8_t>(why);
}

/// Also where something may stand. What is likelier floor than that, up to `even`, is no evidence at all: not against an obstacle, as the
/// same pixels in frame after frame are no more ground than in one; nor for one, as rough ground would become an obstacle if only looked at
/// for long.
void FusedMap::add_obstacle(int row, int column, int8_t seen, CellReason why, std::span<Image* const> out) noexcept {
  const auto kind = why == CellReason::drop_off ? FusedGrid::Kind::drop_off : FusedGrid::Kind::obstacle;
  if (seen > even) grid_.add(row, column, for_obstacle * static_cast<float>(seen - even) / even, kind);
  const int8_t percent = grid_.percent(row, column);
  out[0]->row<int8_t>(row)[column] = percent;
  uint8_t& reason = out[1]->row<uint8_t>(row)[column];
  // What is suspected and not known to be free is no ground that was never looked at.
  if (percent >= occupied_from || percent < 0) {
    const auto is = percent < 0 ? kind : grid_.kind(row, column);  // nothing is remembered: what this frame says
    reason = static_cast<uint8_t>(is == FusedGrid::Kind::drop_off ? CellReason::drop_off : CellReason::obstacle);
  } else if (why == CellReason::floor) {
    reason = static_cast<uint8_t>(why);
  }
}

/// Where the grids are turned against each other by 45 degrees a cell may lie between all middles.
void FusedMap::add_missed(const Frame& frame, std::span<Image* const> out) noexcept {
  for (int r = 0; r < rows_; ++r) {
    const int8_t* seen = frame.occupancy.row<int8_t>(r);
    for (int c = 0; c < columns_; ++c) {
      if (seen[c] < occupied_from || asked_[static_cast<size_t>(r * columns_ + c)]) continue;
      const OnGround at = frame.placement.outside((c + 0.5 - columns_ / 2.0) * config_.map.cell, (rows_ - r - 0.5) * config_.map.cell);
      const int row = grid_.row(at.x), column = grid_.column(at.y);
      if (grid_.holds(row, column)) add_obstacle(row, column, seen[c], CellReason{frame.reason.row<uint8_t>(r)[c]}, out);
    }
  }
}

}  // namespace vdisp
