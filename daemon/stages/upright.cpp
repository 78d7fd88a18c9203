// upright.cpp: samples of a column of the image from below, and the runs of them that rise at one distance.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/upright.h"

#include <algorithm>
#include <cmath>

#include "daemon/stages/projection.h"

namespace vdisp {
namespace {

constexpr int columns_looked_at = 160, rows_looked_at = 120;  // of any image: every 4th in 640x480
constexpr float disparity_noise = 0.4f;                       // px
constexpr float lean = 0.5f;                                  // of its height: what leans more is a slope
constexpr float lean_of_hidden = 1;                           // the same for what begins behind an edge
constexpr float level_of_step = 0.5f;                         // of max_height: what ends no higher over the floor ends level with it
constexpr float part_seen = 0.5f;                             // of max_height: what rises so much and hides its foot may be higher
constexpr float part_risen_after = 0.7f, part_risen = 0.3f;   // of that part: when this many rows of it are seen it has risen by this
constexpr int least_columns = 3;  // beside each other, of which all from the third on are obstacle: what is not high over the floor
constexpr size_t edge_samples = 4;
constexpr size_t most_beside = 8;  // things in a column
constexpr int most_gap = 1;        // samples without a disparity within one thing
constexpr int same_thing = 6;      // 1/16 px around a sample

}  // namespace

float Upright::depth(const Sample& of, float leans) const { return leans * static_cast<float>(config_.limit.max_height) + noise(of); }

float Upright::level() const { return level_of_step * static_cast<float>(config_.limit.max_height); }

float Upright::rise_of(float px, const Sample& at) const { return px * scale_.rise * at.depth; }

bool Upright::gap(const Sample& below, const Sample& above) const { return below.row - above.row > (most_gap + 1) * down_; }

void Upright::prepare(const ImageSpec& disparity) {
  across_ = std::max((disparity.width + columns_looked_at / 2) / columns_looked_at, 1);
  down_ = std::max((disparity.height + rows_looked_at / 2) / rows_looked_at, 1);
  columns_ = disparity.width / across_;
  rows_ = disparity.height / down_;
  gathered_.assign(static_cast<size_t>(columns_ * rows_), 0);
  ranges_.assign(16 * static_cast<size_t>(config_.image_source.ndisp), Range{});
  samples_.reserve(static_cast<size_t>(rows_));
  for (auto* seen : {&now_, &before_}) seen->reserve(most_beside);
}

void Upright::mark(const Image& disparity, const FloorModel& model, std::span<Image* const> surfaces) noexcept {
  const Marks marks{disparity, *surfaces[0], *surfaces[1], *surfaces[2]};
  const CameraGeometry& g = disparity.camera;
  const float fb = g.f * g.baseline;
  const float high = static_cast<float>(model.height_m);
  scale_ = {g.f, disparity_noise / fb, 1 / (g.f * high), high / fb, 0};
  const kernels::Search search = search_of(g, static_cast<int>(ranges_.size()));
  for (int column = search.least - search.first; column < search.columns; ++column)
    ranges_[static_cast<size_t>(column)] = range_of(fb / static_cast<float>(true_disparity(g, column)));
  scale_.dents = dents(marks, search.first + static_cast<int>(16 * fb / static_cast<float>(config_.map.range)));
  gather(disparity);
  now_.clear();
  for (int number = 0; number < columns_; ++number) mark_column(marks, look(disparity, model, number), number * across_);
}

Upright::Range Upright::range_of(float depth) const {
  const float seen = part_seen * static_cast<float>(config_.limit.max_height);
  return {depth,
          static_cast<int16_t>(std::clamp(part_risen_after * seen * scale_.focal / depth / static_cast<float>(down_), 1.0f, 1000.0f))};
}

void Upright::gather(const Image& disparity) noexcept {
  for (int i = 0; i < rows_; ++i) {
    const int16_t* row = disparity.row<int16_t>(disparity.spec.height - 1 - down_ / 2 - i * down_) + across_ / 2;
    for (int number = 0; number < columns_; ++number) gathered_[static_cast<size_t>(number * rows_ + i)] = row[number * across_];
  }
}

std::span<const Upright::Sample> Upright::look(const Image& disparity, const FloorModel& model, int number) noexcept {
  const CameraGeometry& g = disparity.camera;
  const kernels::Search search = search_of(g, static_cast<int>(ranges_.size()));
  const float height = static_cast<float>(model.height_m);
  const float sin_pitch = static_cast<float>(std::sin(model.pitch_rad)), cos_pitch = static_cast<float>(std::cos(model.pitch_rad));
  const float cos_roll = static_cast<float>(std::cos(model.roll_rad)) / g.f, sin_roll = static_cast<float>(std::sin(model.roll_rad)) / g.f;
  const float aside = (static_cast<float>(number * across_ + across_ / 2) - g.cx) * sin_roll;
  const int16_t* column = &gathered_[static_cast<size_t>(number * rows_)];
  samples_.clear();
  for (int i = 0; i < rows_; ++i) {
    const int v = disparity.spec.height - 1 - down_ / 2 - i * down_;
    if (!search.counts(column[i])) continue;
    const Range& range = ranges_[static_cast<size_t>(column[i] - search.first)];
    const float z = range.depth, slope = aside + (static_cast<float>(v) - g.cy) * cos_roll;
    samples_.push_back(
        {z * (cos_pitch - slope * sin_pitch), height - z * (sin_pitch + slope * cos_pitch), z, v, range.rises_after, column[i]});
  }
  return samples_;
}

size_t Upright::run_from(std::span<const Sample> samples, size_t first, float leans) const noexcept {
  const Sample& foot = samples[first];
  const float reach = depth(foot, leans);
  size_t end = first + 1;
  while (end < samples.size() && std::abs(samples[end].ahead - foot.ahead) <= reach && !gap(samples[end - 1], samples[end])) ++end;
  return end;
}

const Upright::Sample* Upright::edge_before(std::span<const Sample> samples, size_t first) const noexcept {
  // The window of the matcher blurs an edge over a few samples. Floor that leads up to a foot recedes too, but slowly.
  const Sample& foot = samples[first];
  for (size_t back = 1; back <= std::min<size_t>(first, edge_samples); ++back) {
    const Sample& before = samples[first - back];
    if (foot.ahead - before.ahead >
        depth(foot, lean) + static_cast<float>(before.row - foot.row) * scale_.recedes * foot.depth * foot.depth)
      return &before;
  }
  return nullptr;
}

void Upright::mark_column(const Marks& marks, std::span<const Sample> samples, int column) noexcept {
  const float step = static_cast<float>(config_.limit.max_height), range = static_cast<float>(config_.map.range);
  std::swap(before_, now_);
  now_.clear();
  const float least_rise = part_risen * part_seen * step;
  for (size_t first = 0; first < samples.size();) {
    // Floor does not rise: most samples are done with here.
    const size_t some = first + static_cast<size_t>(samples[first].rises_after);
    if (samples[first].ahead > range || some >= samples.size() || samples[some].up - samples[first].up < least_rise) {
      ++first;
      continue;
    }
    size_t end = run_from(samples, first, lean_of_hidden);
    const float foot = samples[first].up;
    if (samples[end - 1].up - foot < part_seen * step) {
      ++first;
      continue;
    }
    const Sample* edge = edge_before(samples, first);
    const size_t steep = run_from(samples, first, lean);
    const auto rises = [&](size_t to) { return samples[to - 1].up - foot; };
    const Sample& top = samples[steep - 1];
    kernels::Surface is = kernels::Surface::obstacle;
    const Rise* same = edge ? beside(top, false) : nullptr;
    if (edge && is_ditch(samples, first, steep, *edge, same)) {
      is = kernels::Surface::below;
      end = steep;
      note(top, same, true, false);
    } else if (edge) {
      // A few columns alone may be a false match.
      if (rises(end) < step || !same || same->columns + 1 < least_columns) is = kernels::Surface::none;
      if (rises(end) >= step) note(top, same, false, false);
    } else if (rises(steep) < step) {
      ++first;
      continue;
    } else {
      end = steep;
      same = beside(top, true);
      note(top, same, false, true);
      // Its upper part is an obstacle by its height: this is its foot, and shall not be floor. A few columns alone may be a false match.
      const bool few = !same || same->columns + 1 < least_columns;
      if (few || std::abs(marks.height.row<int16_t>(samples[first].row)[column + across_ / 2]) <= 1000 * level())
        is = kernels::Surface::none;
    }
    mark_run(marks, samples.subspan(first, end - first), is, edge != nullptr, column);
    first = end;
  }
}

const Upright::Rise* Upright::beside(const Sample& top, bool standing) const {
  const auto at = std::find_if(before_.begin(), before_.end(), [&](const Rise& r) {
    return r.standing == standing && std::abs(r.ahead - top.ahead) <= depth(top, lean_of_hidden) && std::abs(r.up - top.up) <= level();
  });
  return at == before_.end() ? nullptr : &*at;
}

void Upright::note(const Sample& top, const Rise* same, bool ditch, bool standing) noexcept {
  if (now_.size() < most_beside) now_.push_back({top.ahead, top.up, same ? same->columns + 1 : 1, ditch, standing});
}

void Upright::mark_run(const Marks& marks, std::span<const Sample> run, kernels::Surface is, bool hidden, int column) const noexcept {
  // Floor before or behind it is near enough to be part of the run: the half that has none says where it stands.
  const bool ditch = is == kernels::Surface::below;
  float sum = 0;
  int count = 0;
  const float middle = (run.front().up + run.back().up) / 2;
  for (const Sample& s : run) {
    if ((s.up < middle) != ditch) continue;
    sum += s.ahead;
    ++count;
  }
  const float ahead = sum / static_cast<float>(std::max(count, 1)), lean_of_half = lean / 2 * static_cast<float>(config_.limit.max_height);
  const int width = marks.disparity.spec.width, height = marks.disparity.spec.height;
  for (const Sample& s : run) {
    const bool off = (ditch ? s.ahead - ahead : ahead - s.ahead) > lean_of_half + noise(s) / 2;
    if (off && !(hidden && !ditch)) continue;
    // What is an obstacle by its height is one beside it as well.
    const auto by_height = static_cast<kernels::Surface>(marks.surface.row<uint8_t>(s.row)[column + across_ / 2]);
    if (by_height == kernels::Surface::obstacle || by_height == kernels::Surface::overhang) continue;
    const kernels::Surface here = off ? kernels::Surface::none : is;
    const int below = hidden && &s == &run.front() ? 2 * down_ : down_ - down_ / 2;
    for (int v = std::max(s.row - down_ / 2, 0); v < std::min(s.row + below, height); ++v) {
      const int16_t* d = marks.disparity.row<int16_t>(v);
      uint8_t* surface = marks.surface.row<uint8_t>(v);
      int16_t* obstacles = marks.obstacles.row<int16_t>(v);
      for (int u = std::max(column - across_, 0); u < std::min(column + 2 * across_, width); ++u) {
        const auto was = static_cast<kernels::Surface>(surface[u]);
        if ((was != kernels::Surface::floor && was != kernels::Surface::below) || std::abs(d[u] - s.disparity) > same_thing) continue;
        surface[u] = static_cast<uint8_t>(here);
        if (here == kernels::Surface::obstacle) obstacles[u] = d[u];
      }
    }
  }
}

}  // namespace vdisp
