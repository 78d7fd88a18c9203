// floor_profile.cpp: points into a grid of distance and height, and the cheapest way through it.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/floor_profile.h"

#include <algorithm>
#include <cmath>

#include "daemon/stages/projection.h"

namespace vdisp {
namespace {

constexpr double roughness = 0.02;        // m, of ground that is one with its profile
constexpr double disparity_noise = 0.35;  // px
constexpr float most_counted = 8;         // points of a distance: more say nothing new
constexpr float least_shown = 1;          // points that show that the floor is there: falling ground is grazing, and hardly matched
// And of the ground seen so far off: where more is seen higher and lower, the few between are the face of a kerb.
constexpr float share_shown = 0.1f;
constexpr float unlikely = 1e6f;
constexpr size_t bank_step = 2;  // points, of which one tells how the ground is banked
// A floor recedes from row to row, least where it rises as steeply as it may, and what falls recedes faster than the plane.
constexpr int recede_rows = 8;          // of 480, up and down
constexpr double least_receding = 0.5;  // of what it should by
constexpr float price_of_step = 0.10f, price_of_level = 0.002f, price_of_below = 1.2f;

}  // namespace

void FloorProfile::prepare(size_t most_points) {
  ground_.reserve(most_points);
  seen_.assign(bins * levels, 0.0f);
  cost_.assign(bins * levels, 0.0f);
  came_from_.assign(bins * levels, 0);
}

void FloorProfile::measure(const PlaneSearch& points, const Image& disparity, FloorModel& model) noexcept {
  Scale scale{};
  scale.count = std::clamp(static_cast<int>(std::ceil(config_.map.range / config_.map.cell)), 8, bins);
  scale.step = config_.map.range / scale.count;
  scale.start = scale.step / 2;
  scale.level = scale.step * std::tan(config_.floor.maxSlope) / reach;
  count(points, disparity, model, scale);
  find_way(model, stereo_view(disparity), scale);
  write(scale, model);
}

void FloorProfile::count(const PlaneSearch& points, const Image& disparity, const FloorModel& model, const Scale& scale) noexcept {
  std::fill(seen_.begin(), seen_.end(), 0.0f);
  ground_.clear();
  const StereoView view = stereo_view(disparity);
  const double fb = view.f * view.baseline, cos_pitch = std::cos(model.pitch_rad), sin_pitch = std::sin(model.pitch_rad);
  const double down = 1 / (16 * model.a), middle_disparity = down * (view.cy - model.b);
  const double cos_roll = std::cos(model.roll_rad), sin_roll = std::sin(model.roll_rad);
  const int rows = std::max(recede_rows * disparity.spec.height / 480, 2), bottom = disparity.spec.height - 1;
  const double least_fall = least_receding * 16 * rows * down, steepest = std::tan(config_.floor.maxSlope), per_level = 1 / scale.level,
               per_step = 1 / scale.step;
  for (size_t i = 0; i < points.points(); ++i) {
    const auto [u, v, d] = points.point(i);
    if (d <= 0.5) continue;
    const double inverse = 1 / d, z = fb * inverse, y = (u * sin_roll + v * cos_roll) * z / view.f, ahead = z * cos_pitch - y * sin_pitch;
    const double steps = ahead * per_step;
    if (!(steps >= 0 && steps < scale.count)) continue;
    const int bin = static_cast<int>(steps);
    const double floor = model.tilt * u + down * v + middle_disparity, height = model.height_m * (1 - floor * inverse);
    // Rounded by casts: lround is a call.
    const double level = std::max(height * per_level + middle + 0.5, 0.0);
    if (level >= levels) continue;
    const int column = static_cast<int>(u + view.cx + 0.5), row = static_cast<int>(v + view.cy + 0.5);
    const int16_t here = disparity.row<int16_t>(row)[column], near = disparity.row<int16_t>(std::min(row + rows, bottom))[column],
                  far = disparity.row<int16_t>(std::max(row - rows, 0))[column];
    const double least = height < 0 ? least_fall : least_fall * model.height_m / (model.height_m + ahead * steepest);
    const bool upright = (near > 0 && row + rows <= bottom && near - here < least) || (far > 0 && row >= rows && here - far < least);
    if (upright) continue;
    seen_[cell(bin, static_cast<int>(level))] += 1;
    if (i % bank_step == 0 && ground_.size() < ground_.capacity())
      ground_.push_back({bin, static_cast<float>((u * cos_roll - v * sin_roll) * z / view.f), static_cast<float>(height)});
  }
}

void FloorProfile::find_way(const FloorModel& model, const StereoView& view, const Scale& scale) noexcept {
  bool ground_seen = false;
  for (int bin = 0; bin < scale.count; ++bin) {
    const double z = scale.start + bin * scale.step;
    const double noise = model.height_m * disparity_noise * std::hypot(z, model.height_m) / (view.f * view.baseline);
    const int on = std::clamp(static_cast<int>((roughness + 1.5 * noise) / scale.level), 1, middle / 2), gap = 2 * on;
    band_[bin] = on;
    float* cost = &cost_[static_cast<size_t>(bin * levels)];
    float all = 0, sums[levels + 1];
    for (int level = 0; level < levels; ++level) {
      sums[level] = all;
      all += seen_[cell(bin, level)];
    }
    sums[levels] = all;
    bool carries[levels];
    for (int level = 0; level < levels; ++level) {
      const float on_it = sums[std::min(level + on + 1, levels)] - sums[std::max(level - on, 0)], below = sums[std::max(level - gap, 0)];
      cost[level] = (price_of_below * std::min(below, most_counted) - std::min(on_it, most_counted)) / most_counted +
                    price_of_level * static_cast<float>(std::abs(level - middle));
      carries[level] = on_it >= std::max(least_shown, share_shown * all);
    }
    ground_seen = ground_seen || sums[middle + on + 1] - sums[middle - on] >= least_shown;
    if (!ground_seen) {
      // The rover stands on the plane: up to where ground is first seen that is all there is to say.
      for (int level = 0; level < levels; ++level) cost[level] = level == middle ? 0 : unlikely;
    }
    if (bin == 0) continue;
    const float* before = cost - levels;
    for (int level = 0; level < levels; ++level) {
      int best = 0;
      float least = before[level];
      // It may only fall where it is seen to: what lies lower behind a gap is the bottom of a drop-off, or may be.
      const int highest = carries[level] ? reach : 0;
      for (int step = -reach; step <= highest; ++step) {
        if (level + step < 0 || level + step >= levels) continue;
        const float here = before[level + step] + price_of_step * static_cast<float>(std::abs(step));
        if (here < least) {
          least = here;
          best = step;
        }
      }
      cost[level] += least;
      came_from_[static_cast<size_t>(bin * levels + level)] = static_cast<int8_t>(best);
    }
  }
  const float* last = &cost_[static_cast<size_t>((scale.count - 1) * levels)];
  int level = static_cast<int>(std::min_element(last, last + levels) - last);
  for (int bin = scale.count - 1; bin >= 0; --bin) {
    way_[bin] = level;
    level += came_from_[static_cast<size_t>(bin * levels + level)] * (bin > 0);
  }
}

void FloorProfile::write(const Scale& scale, FloorModel& model) const noexcept {
  model.profile_count = static_cast<uint32_t>(scale.count);
  model.profile_start_m = static_cast<float>(scale.start);
  model.profile_step_m = static_cast<float>(scale.step);
  model.profile_seen = 0;
  float exact[bins];
  for (int bin = 0; bin < scale.count; ++bin) {
    // The way may lie anywhere in a band of points: their mean, taken twice, is its middle.
    double place = way_[bin], count = 0;
    for (int round = 0; round < 2; ++round) {
      const int at = static_cast<int>(std::lround(place)), first = std::max(at - band_[bin], 0),
                last = std::min(at + band_[bin], levels - 1);
      double sum = 0;
      count = 0;
      for (int level = first; level <= last; ++level) {
        const double points = static_cast<double>(seen_[cell(bin, level)]);
        sum += points * level;
        count += points;
      }
      if (count < least_shown) break;
      place = sum / count;
    }
    if (count >= least_shown) model.profile_seen = static_cast<uint32_t>(bin + 1);
    exact[bin] = static_cast<float>((place - middle) * scale.level);
  }
  for (int bin = 0; bin < scale.count; ++bin) {
    float sum = 0, weight = 0;
    for (int k = std::max(bin - 2, 0); k <= std::min(bin + 2, scale.count - 1); ++k) {
      const float w = static_cast<float>(3 - std::abs(k - bin));
      sum += w * exact[k];
      weight += w;
    }
    model.profile_m[bin] = sum / weight;
  }
}

}  // namespace vdisp
