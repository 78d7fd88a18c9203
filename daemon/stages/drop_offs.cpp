// drop_offs.cpp: part of `occupancy`: where the ground ends.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <utility>

#include "daemon/stages/occupancy.h"

namespace vdisp {
namespace {

constexpr double least_beyond = 0.4;                      // of what a cell shows
constexpr int least_hole = 4;                             // samples of it
constexpr double visible_by = 0.09, beside_slope = 0.05;  // rad, m
constexpr int floor_leads = 3;                            // cells: floor no farther than this before a drop-off leads up to it
constexpr int slope_cells = 5;                            // that the ground's slope before a drop-off is taken from
constexpr int hidden_cells = 4, least_hidden = 2;         // of a drop-off: cells looked at, and through which what is lower is seen
constexpr int edge_beside = 2;                            // of a drop-off, in the next column: cells it may be nearer or farther there
constexpr int edge_cells = 2;                             // of a drop-off that are told; what lies behind is hidden
constexpr int beside_lone = 4;                            // cells: as far off is the same edge in the next column
constexpr double windows_of_edge = 3.5;                   // side by side, that are no false match
constexpr int most_between = 20, off_line = 2;            // cells: edges that are one, and how straight it is
constexpr int least_edge = 3, sure_edge = 6;              // cells: an edge that goes on, and one that itself says where
constexpr int edge_slope = 8;                             // cells of it that say so
constexpr int least_ends = 3;                             // columns in which the floor ends on the line of an edge of which less is seen

}  // namespace

Occupancy::Beyond Occupancy::what_is_beyond(const Tally& tally) noexcept {
  const auto is_enough = [&](double count) { return count >= least_hole && count >= least_beyond * tally.all; };
  auto [count, height, ahead] = tally.beyond;
  const bool sure = is_enough(count);
  if (!sure) {
    count += tally.lower.count;
    height += tally.lower.height;
    ahead += tally.lower.ahead;
  }
  if (!is_enough(count)) return {};
  return {static_cast<float>(height / count), static_cast<float>(ahead / count), 2 * tally.wall > count, sure};
}

void Occupancy::drop_offs(const Inputs& in, Image& occupancy, Image& reason) noexcept {
  std::fill(edges_.begin(), edges_.end(), -1);
  const double cell = config_.map.cell, least = hole_of_step * config_.limit.max_height;
  for (int column = 0; column < columns_; ++column) {
    int last_floor = -1;
    for (int row = rows_ - 1; row >= 0; --row) {
      uint8_t& why = reason.row<uint8_t>(row)[column];
      if (why == static_cast<uint8_t>(CellReason::floor)) last_floor = row;
      const Beyond& seen = beyond_[static_cast<size_t>(row * columns_ + column)];
      if (!seen.sure || last_floor < 0 || last_floor - row > floor_leads) continue;
      const double edge = (rows_ - last_floor - 0.5) * cell, here = in.floor.elevation(edge);
      const double slope = std::min((here - in.floor.elevation(edge - slope_cells * cell)) / (slope_cells * cell), 0.0);
      // A slope falls away gradually, as far as it can be seen at all: 5 degrees less steep than the line of sight.
      const double sight = std::atan2(in.pose.height - here, edge),
                   steepest = std::tan(std::min(config_.floor.maxSlope, sight - visible_by));
      const double past = (last_floor - row - 0.5) * cell, tangent = std::tan(sight);
      const double of_slope = steepest > 0 ? past * tangent * steepest / (tangent - steepest) + beside_slope : 0;
      const auto is_deep = [&](int r, int c, double at_least) {
        if (r < 0 || r >= rows_ || c < 0 || c >= columns_) return false;
        const Beyond& through = beyond_[static_cast<size_t>(r * columns_ + c)];
        if (through.wall) return true;
        // What may as well stand behind a crest speaks for an edge only beside what hides the rest of it.
        return through.ahead > 0 && (through.sure || is_hidden(r, c)) &&
               here + slope * (static_cast<double>(through.ahead) - edge) - static_cast<double>(through.height) >= at_least;
      };
      if (!is_deep(row, column, std::max(least, of_slope))) continue;
      // What is lower lies behind a hidden stretch, seen through all the cells there; one false match is seen through one.
      int deep = 0;
      for (int r = row; r > row - hidden_cells; --r) deep += is_deep(r, column, least);
      // An edge is wider than a cell, or the rover need not mind it.
      bool beside = false;
      for (int r = row - edge_beside; r <= row + edge_beside; ++r)
        beside = beside || is_deep(r, column - 1, least) || is_deep(r, column + 1, least);
      if (deep < least_hidden || !beside) continue;
      // The ground ends somewhere between the last floor and what is seen through.
      for (int r = last_floor - 1; r > std::max(row - edge_cells, -1); --r) {
        uint8_t& edge_why = reason.row<uint8_t>(r)[column];
        if (edge_why == static_cast<uint8_t>(CellReason::obstacle)) break;
        if (edge_row(column) < 0) edges_[static_cast<size_t>(column)] = r;
        occupancy.row<int8_t>(r)[column] = 100;
        edge_why = static_cast<uint8_t>(CellReason::drop_off);
      }
      last_floor = -1;
    }
  }
}

bool Occupancy::floor_behind(int line, int column, const Image& reason) const noexcept {
  for (int r = std::max(line - off_line - hidden_cells, 0); r < line - off_line; ++r)
    if (reason.row<uint8_t>(r)[column] == static_cast<uint8_t>(CellReason::floor)) return true;
  return false;
}

int Occupancy::end_of_floor(int line, int column, const Image& occupancy, const Image& reason) const noexcept {
  for (int r = std::max(line - off_line, 0); r <= std::min(line + off_line, rows_ - 2); ++r)
    if (reason.row<uint8_t>(r + 1)[column] == static_cast<uint8_t>(CellReason::floor) && occupancy.row<int8_t>(r)[column] < 0) return r;
  return -1;
}

void Occupancy::tell_end(int line, int column, Image& occupancy, Image& reason) const noexcept {
  const int row = end_of_floor(line, column, occupancy, reason);
  if (row < 0) return;
  occupancy.row<int8_t>(row)[column] = 100;
  reason.row<uint8_t>(row)[column] = static_cast<uint8_t>(CellReason::drop_off);
}

/// Between two parts of an edge that are seen nothing may be matched, neither grazing ground nor what lies lower. Where the floor ends all
/// along the line between them, and is seen nowhere behind it, that is the edge too.
void Occupancy::join_edges(Image& occupancy, Image& reason) const noexcept {
  int before = -1;
  for (int column = 0; column < columns_; ++column) {
    const int here = edges_[static_cast<size_t>(column)];
    if (here < 0) continue;
    const int left = std::exchange(before, column), between = column - left - 1;
    if (left < 0 || between < 1 || between > most_between) continue;
    const int there = edges_[static_cast<size_t>(left)];
    const auto on_line = [&](int c) { return there + (here - there) * (c - left) / (column - left); };
    bool open = false;
    for (int c = left + 1; c < column && !open; ++c) open = floor_behind(on_line(c), c, reason);
    for (int c = left + 1; c < column && !open; ++c) tell_end(on_line(c), c, occupancy, reason);
  }
}

/// An edge goes on to both sides of what is seen of it: in gaps between what stands before it, and at the border of the picture, next to
/// nothing can be matched. Where the floor ends along its line, that is the edge too; but not where floor is seen behind the line.
void Occupancy::extend_edges(Image& occupancy, Image& reason) const noexcept {
  for (int end = 0; end < columns_; ++end) {
    for (const int side : {-1, 1}) {
      if (edge_row(end) < 0 || edge_row(end + side) >= 0) continue;
      int first = end;
      while (std::abs(end - first) < edge_slope && edge_row(first - side) >= 0 &&
             std::abs(edge_row(first - side) - edge_row(first)) <= beside_lone)
        first -= side;
      const int length = std::abs(end - first);
      Line line{end, side, edge_row(end) - edge_row(first), length};
      if (length + 1 < sure_edge && !find_line(occupancy, reason, line) && length + 1 < least_edge) continue;
      const int on_it = follow(line, occupancy, reason).columns;
      for (int on = 1; on <= on_it; ++on) tell_end(row_on(line, on), end + side * on, occupancy, reason);
    }
  }
  for (int end = 0; end < columns_; ++end)
    for (const int side : {-1, 1})
      if (edge_row(end) >= 0 && edge_row(end + side) < 0) tell_hidden(edge_row(end), end + side, occupancy, reason);
}

/// Beside what hides the rest of an edge neither half a window can be matched nor the strip that one camera sees alone: it goes on for a
/// cell at least. Occluded is also what something farther is seen through: an obstacle must stand before it.
void Occupancy::tell_hidden(int line, int column, Image& occupancy, Image& reason) const noexcept {
  if (column < 0 || column >= columns_) return;
  uint8_t& why = reason.row<uint8_t>(line)[column];
  if (why != static_cast<uint8_t>(CellReason::occluded) || !is_hidden(line, column) || floor_behind(line, column, reason)) return;
  occupancy.row<int8_t>(line)[column] = 100;
  why = static_cast<uint8_t>(CellReason::drop_off);
}

/// As far as nothing speaks against it: no columns at all where floor is seen behind one of them.
Occupancy::Followed Occupancy::follow(const Line& line, const Image& occupancy, const Image& reason) const noexcept {
  Followed followed;
  for (int on = 1; on <= most_between; ++on) {
    const int column = line.end + line.side * on, row = row_on(line, on);
    if (column < 0 || column >= columns_ || edge_row(column) >= 0 || row - off_line - hidden_cells < 0 || row + off_line + 1 >= rows_)
      break;
    if (floor_behind(row, column, reason)) return {};
    followed.columns = on;
    followed.ends += end_of_floor(row, column, occupancy, reason) >= 0;
  }
  return followed;
}

/// Too little of an edge is seen to say where it leads: along the line on which the floor ends most often.
bool Occupancy::find_line(const Image& occupancy, const Image& reason, Line& line) const noexcept {
  int most = least_ends - 1;
  for (int turn = 0; turn <= 2 * edge_slope; ++turn) {
    const int rise = (turn + 1) / 2 * (turn % 2 ? -1 : 1);  // the least first
    const Line other{line.end, line.side, rise, edge_slope};
    const int ends = follow(other, occupancy, reason).ends;
    if (ends <= most) continue;
    most = ends;
    line = other;
  }
  return most >= least_ends;
}

/// How many cells, at this row's distance, those windows of the matcher are wide that are no false match.
double Occupancy::windows(const Inputs& in, int row) const noexcept {
  return windows_of_edge * config_.image_source.corrsize / in.view.f * (rows_ - row);
}

/// The nearest row of the edge in a column beside one where it is in `row`; -1: it is not there.
int Occupancy::edge_near(int row, int column, const Image& reason) const noexcept {
  if (column < 0 || column >= columns_) return -1;
  for (int off = 0; off <= beside_lone; ++off)
    for (const int r : {row - off, row + off})
      if (r >= 0 && r < rows_ && reason.row<uint8_t>(r)[column] == static_cast<uint8_t>(CellReason::drop_off)) return r;
  return -1;
}

/// From a column on in which an edge in `row` is not seen: the next one where it is, if what stands before it hides it all the way between;
/// -1: none.
int Occupancy::edge_behind(int row, int column, int side, const Image& occupancy, const Image& reason) const noexcept {
  for (int between = 0; between < most_between; ++between, column += side) {
    if (column < 0 || column >= columns_) return -1;
    if (edge_near(row, column, reason) >= 0) return column;
    if (occupancy.row<int8_t>(row)[column] >= 0 || floor_behind(row, column, reason) || !is_hidden(row, column)) return -1;
  }
  return -1;
}

/// In how many columns an edge is seen, counted up to `most`. One column without it between two with it does not part them, nor do those
/// in which something stands before it.
int Occupancy::columns_of_edge(int row, int column, int most, const Image& occupancy, const Image& reason) const noexcept {
  int count = 1;
  for (const int side : {-1, 1}) {
    int at = row;
    for (int c = column + side; c >= 0 && count < most; c += side) {
      if (edge_near(at, c, reason) < 0) {
        c = edge_near(at, c + side, reason) >= 0 ? c + side : edge_behind(at, c, side, occupancy, reason);
        if (c < 0) break;
      }
      at = edge_near(at, c, reason);
      ++count;
    }
  }
  return count;
}

/// An edge seen in one column alone, or in no more than a few windows of the matcher are wide, is a false match: what is there is
/// unknown.
void Occupancy::refuse_lone_edges(const Inputs& in, Image& occupancy, Image& reason) noexcept {
  constexpr auto drop_off = static_cast<uint8_t>(CellReason::drop_off);
  std::fill(known_.begin(), known_.end(), uint8_t{0});
  for (int row = 0; row < rows_; ++row) {
    const int least = std::max(static_cast<int>(std::ceil(windows(in, row))), 2);
    for (int column = 0; column < columns_; ++column)
      known_[static_cast<size_t>(row * columns_ + column)] =
          reason.row<uint8_t>(row)[column] == drop_off && columns_of_edge(row, column, least, occupancy, reason) < least;
  }
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < columns_; ++column) {
      if (!known_[static_cast<size_t>(row * columns_ + column)]) continue;
      occupancy.row<int8_t>(row)[column] = -1;
      reason.row<uint8_t>(row)[column] = static_cast<uint8_t>(CellReason::rejected);
      if (edge_row(column) == row) edges_[static_cast<size_t>(column)] = -1;
    }
  }
}

}  // namespace vdisp
