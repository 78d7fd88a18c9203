// filling.cpp: runs of even samples by row, linked to surfaces, each filled or left alone.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/filling.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "daemon/stages/limits_mm.h"
#include "daemon/stages/local_floor.h"
#include "daemon/stages/projection.h"

namespace vdisp {
namespace {

constexpr int columns_looked_at = 160, rows_looked_at = 120;  // of any image: every 4th in 640x480
constexpr size_t runs_of_row = 32;
constexpr int least_run = 3;          // samples
constexpr int even_within = 16;       // grey levels, within a sample: camera noise
constexpr int even_step = 10;         // from sample to sample, means
constexpr float even_rows = 8;        // of whole runs, from row to row
constexpr int beside = 2;             // samples: edges are no straighter
constexpr int border_within = 4;      // samples: the match nearest to a run is its border
constexpr float most_off = 0.2f;      // of its matches, that may lie off it
constexpr int least_rows = 4;         // of an edge
constexpr int most_beyond = 2;        // rows that a surface may go on below the end of its edge
constexpr float least_share = 0.6f;   // of a surface's rows, that have both edges
constexpr float foot_of_step = 0.4f;  // of max_height: as near to the floor an edge ends
constexpr double lean = 0.8;          // of its width: a surface's ends may lie so far behind each other
constexpr int16_t least_matched = rejected_base;

}  // namespace

void Filling::prepare(const ImageSpec& disparity) {
  across_ = std::max((disparity.width + columns_looked_at / 2) / columns_looked_at, 1);
  down_ = std::max((disparity.height + rows_looked_at / 2) / rows_looked_at, 1);
  columns_ = disparity.width / across_;
  rows_ = disparity.height / down_;
  runs_.reserve(runs_of_row * static_cast<size_t>(rows_));
  surface_.reserve(static_cast<size_t>(rows_));
}

float Filling::height(const Frame& frame, int column, int row, float disparity) {
  const int d = static_cast<int>(std::lround(disparity)), at = d - frame.search.first;
  if (!frame.search.counts(d)) return NAN;
  const float floor = static_cast<float>(frame.plane.at(column, row, frame.view));
  const kernels::HeightOf of = frame.table[at];
  return frame.camera_mm - floor * of.inverse - of.profile;
}

void Filling::fill(const Image& disparity, const Image& left, const FloorModel& model, const kernels::HeightTable& table,
                   std::span<Image* const> surfaces) noexcept {
  if (config_.limit.fill == 0) return;
  const StereoView view = stereo_view(disparity);
  const Frame frame{disparity,
                    left,
                    *surfaces[1],
                    view,
                    LocalFloor(model, view).plane(),
                    static_cast<float>(1000 * model.height_m),
                    search_of(disparity.camera, 16 * disparity.camera.disparities),
                    table};
  runs_.clear();
  size_t above = 0;
  for (int number = 0; number < rows_; ++number) {
    const size_t first = runs_.size();
    find_runs(frame, number);
    link(above, first, runs_.size());
    above = first;
  }
  for (const Run& lowest : runs_) {
    if (lowest.goes_on) continue;
    surface_.clear();
    bool open = false;
    for (const Run* run = &lowest;; run = &runs_[static_cast<size_t>(run->above)]) {
      surface_.push_back(*run);
      open = open || run->open;
      if (run->above < 0) break;
    }
    if (!open) fill_surface(frame, surface_, surfaces);
  }
}

/// A sample is even where nothing in the row around it is brighter or darker than noise; a false match there counts as little as none.
void Filling::find_runs(const Frame& frame, int number) noexcept {
  const int v = sampled_row(number);
  const uint8_t* grey = frame.left.row<uint8_t>(v);
  const int16_t* d = frame.disparity.row<int16_t>(v);
  const size_t most = runs_.size() + runs_of_row;
  int from = -1, matched = 0, sum = 0, before = 0;
  const auto close = [&](int to) {
    if (from >= 0 && to - from >= least_run && 4 * matched <= to - from && runs_.size() < most) {
      const auto column = [&](int sample) { return sample * across_ + across_ / 2; };
      runs_.push_back({static_cast<int16_t>(number), static_cast<int16_t>(from), static_cast<int16_t>(to), -1, false, false,
                       static_cast<float>(sum) / static_cast<float>(4 * (to - from)), border(frame, v, column(from), -1),
                       border(frame, v, column(to - 1), 1)});
    }
    from = -1;
  };
  for (int i = 1; i + 1 < columns_; ++i) {
    const int middle = i * across_ + across_ / 2;
    if (from < 0 && d[middle] > least_matched) continue;  // no run begins with a match: mostly there is no more to look at
    const int one = grey[middle - across_ / 2], two = grey[middle], three = grey[middle + across_ / 2], four = grey[middle + across_];
    const int least = std::min(std::min(one, two), std::min(three, four)), greatest = std::max(std::max(one, two), std::max(three, four));
    const int four_greys = one + two + three + four;
    // Two matches side by side are no false ones.
    const bool match = d[middle] > least_matched, matches = match && d[middle + across_] > least_matched;
    if (greatest - least > even_within || matches || (from >= 0 && std::abs(four_greys - before) > 4 * even_step)) {
      close(i);
      continue;
    }
    if (from < 0) {
      from = i;
      sum = matched = 0;
    }
    sum += four_greys;
    matched += match;
    before = four_greys;
  }
  close(columns_ - 1);
}

Filling::Border Filling::border(const Frame& frame, int row, int column, int step) const noexcept {
  const int16_t* d = frame.disparity.row<int16_t>(row);
  const uint8_t* surface = frame.surface.row<uint8_t>(row);
  const int end = column + step * border_within * across_;
  for (int u = column; u != end && u >= 0 && u < frame.disparity.spec.width; u += step) {
    if (d[u] <= 0) continue;
    return {static_cast<int16_t>(u), d[u], surface[u] == static_cast<uint8_t>(kernels::Surface::obstacle)};
  }
  return {};
}

/// A run goes on in the one below it that covers much the same columns as evenly. What goes on beyond its own columns is open.
void Filling::link(size_t first_above, size_t first, size_t end) noexcept {
  const auto even = [&](const Run& one, const Run& other) { return std::abs(one.mean - other.mean) <= even_rows; };
  const auto reaches_out = [](const Run& one, const Run& of) { return one.from < of.from - beside || one.to > of.to + beside; };
  for (size_t i = first; i < end; ++i) {
    Run& run = runs_[i];
    run.open = run.row < 2 || run.row + 3 > rows_;
    for (size_t j = first_above; j < first; ++j) {
      Run& above = runs_[j];
      const int common = std::min(run.to, above.to) - std::max(run.from, above.from);
      if (common <= 0 || !even(run, above)) continue;
      const int shorter = std::min(run.to - run.from, above.to - above.from), longer = std::max(run.to - run.from, above.to - above.from);
      if (run.above < 0 && !above.goes_on && 3 * common >= 2 * shorter && longer <= 2 * shorter) {
        run.above = static_cast<int16_t>(j);
        above.goes_on = true;
      } else if (common >= least_run) {
        run.open = run.open || reaches_out(above, run);
        above.open = above.open || reaches_out(run, above);
      }
    }
  }
}

/// The straight line through the side's matches that are obstacle, and how far down matches go on along it.
bool Filling::edge_of(const Frame& frame, std::span<const Run> surface, Border Run::*side, int16_t Run::*end, Edge& edge) const noexcept {
  float n = 0, x = 0, xx = 0, y = 0, xy = 0;
  for (const Run& run : surface) {
    const Border& at = run.*side;
    if (!at.obstacle) continue;
    const float row = static_cast<float>(sampled_row(run.row) - sampled_row(surface[0].row));
    ++n, x += row, xx += row * row, y += at.disparity, xy += row * at.disparity;
  }
  if (n < least_rows) return false;
  edge.slope = (n * xy - x * y) / (n * xx - x * x);
  edge.at = (y - edge.slope * x) / n - edge.slope * static_cast<float>(sampled_row(surface[0].row));
  int on = 0;
  float off = 0;
  edge.last = -1;
  for (const Run& run : surface) {  // from below
    const Border& at = run.*side;
    const int row = sampled_row(run.row);
    const bool fits = edge.has(at, row);
    off += at.obstacle && !fits;
    if (!fits) continue;
    ++on;
    edge.first = row;
    if (edge.last < 0) edge.last = row, edge.column_last = at.column, edge.end_last = run.*end;
  }
  if (on < least_rows || off > most_off * n) return false;
  // It ends where the surface does, or it is the edge of something before or behind.
  const auto goes_on = std::count_if(surface.begin(), surface.end(), [&](const Run& run) {
    return sampled_row(run.row) > edge.last && std::abs(run.*end - edge.end_last) <= beside;
  });
  if (goes_on > most_beyond) return false;
  const float foot = height(frame, edge.column_last, edge.last + down_, edge.of(edge.last));
  return std::abs(foot) <= 1000 * foot_of_step * static_cast<float>(config_.limit.max_height);
}

void Filling::fill_surface(const Frame& frame, std::span<const Run> surface, std::span<Image* const> out) const noexcept {
  Edge left, right;
  if (surface.size() < least_rows || !edge_of(frame, surface, &Run::left, &Run::from, left) ||
      !edge_of(frame, surface, &Run::right, &Run::to, right))
    return;
  const int common = std::min(left.last, right.last) - std::max(left.first, right.first);
  if (static_cast<float>(common) < least_share * static_cast<float>(down_) * static_cast<float>(surface.size() - 1)) return;
  for (const Run& run : surface) {
    const int v = sampled_row(run.row);
    const int first = left.has(run.left, v) ? run.left.column : run.from * across_,
              last = right.has(run.right, v) ? run.right.column : run.to * across_ - 1;
    const double d_left = static_cast<double>(left.of(v)), d_right = static_cast<double>(right.of(v));
    if (last <= first || d_left <= 0 || d_right <= 0) continue;
    const double fb = frame.view.f * frame.view.baseline, near = 16 * fb / std::max(d_left, d_right),
                 behind = 16 * fb / std::min(d_left, d_right) - near, width = (last - first) / frame.view.f * near;
    if (width > config_.limit.fill || behind > lean * width) continue;
    const float per_column = (right.of(v) - left.of(v)) / static_cast<float>(last - first);
    for (int r = v - down_ / 2; r < v - down_ / 2 + down_; ++r) fill_row(frame, r, first, last, left.of(v), per_column, out);
  }
}

void Filling::fill_row(const Frame& frame, int row, int first, int last, float disparity, float per_column,
                       std::span<Image* const> out) const noexcept {
  const LimitsMm limits(config_);
  const int16_t* d = frame.disparity.row<int16_t>(row);
  int16_t *heights = out[0]->row<int16_t>(row), *obstacles = out[2]->row<int16_t>(row);
  uint8_t* surface = out[1]->row<uint8_t>(row);
  for (int u = first + 1; u < last; ++u) {
    disparity += per_column;
    if (d[u] > least_matched || surface[u] != static_cast<uint8_t>(kernels::Surface::none)) continue;
    const float above = height(frame, u, row, disparity);
    if (!std::isfinite(above)) continue;
    const long mm = std::lround(above);
    if (mm < limits.step || mm >= limits.clearance) continue;
    heights[u] = static_cast<int16_t>(mm);
    surface[u] = static_cast<uint8_t>(kernels::Surface::filled);
    obstacles[u] = static_cast<int16_t>(std::lround(disparity));
  }
}

}  // namespace vdisp
