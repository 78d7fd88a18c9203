// show_scene.cpp: for the eye only: what the planner is told, where it is.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/show_scene.h"

#include <algorithm>
#include <cmath>

namespace vdisp {
namespace {

constexpr uint8_t free_ground[] = {60, 220, 90}, blocked[] = {255, 60, 40}, hole[] = {200, 80, 255}, white[] = {255, 255, 255},
                  blue[] = {80, 160, 255}, yellow[] = {255, 220, 60};

void mix(uint8_t* pixel, const uint8_t (&colour)[3], int of_16) {
  for (int i = 0; i < 3; ++i) pixel[i] = static_cast<uint8_t>((pixel[i] * (16 - of_16) + colour[i] * of_16) / 16);
}

/// What was filled is drawn as the obstacle that it is.
uint8_t as_drawn(uint8_t surface) {
  return static_cast<uint8_t>(surface == static_cast<uint8_t>(Surface::filled) ? Surface::obstacle : Surface{surface});
}

/// m from mark to mark, so that some ten are seen.
double marks(double range) { return range <= 12 ? 1 : range <= 60 ? 5 : 10; }

}  // namespace

std::vector<ImageSpec> ShowScene::check(std::span<const ImageSpec> in) {
  if (in.size() != 4)
    throw FormatError("takes the left view, the surface, the occupancy and the floor model, was given " + std::to_string(in.size()) +
                      " images");
  require(in[0], Pixel::gray8, "the left view");
  require(in[1], Pixel::gray8, "the surface");
  require(in[2], Pixel::int8, "the occupancy");
  require(in[3], Pixel::record, "the floor model");
  require_same_size(in[0], in[1]);
  margin_ = in[0].width;  // a floor that leans by less than 45 degrees stays inside
  depth_disparity_.assign(static_cast<size_t>(in[0].height + 2 * margin_), 0.0f);
  return {{Pixel::rgb8, 0, in[0].width, in[0].height}};
}

Outcome ShowScene::process(std::span<const Image* const> in, std::span<Image* const> out) noexcept {
  const Image &left = *in[0], &surface = *in[1];
  const FloorModel& model = *in[3]->row<FloorModel>(0);
  out[0]->reason = no_metres(surface, model.pitch_rad);
  if (out[0]->reason != Reason::none) return Outcome::invalid;
  const StereoView stereo = stereo_view(surface);
  const LocalFloor floor(model, stereo);
  const double most = true_disparity(surface.camera, 16 * surface.camera.disparities);
  const View view{stereo, floor, floor.plane(), model, most, (in[3]->flags & flag_held) != 0};
  out[0]->flags |= in[3]->flags & flag_held;
  for (int v = 0; v < left.spec.height; ++v) {
    const uint8_t* grey = left.row<uint8_t>(v);
    uint8_t* pixel = out[0]->row<uint8_t>(v);
    for (int u = 0; u < left.spec.width; ++u, pixel += 3) pixel[0] = pixel[1] = pixel[2] = grey[u];
  }
  find_depths(view, left.spec.height);
  tint(view, *in[2], surface, *out[0]);
  outline(surface, *out[0]);
  draw_ranges(view, *out[0]);
  return Outcome::valid;
}

/// From far to near, so that a crest hides what lies behind it. The nearest floor in view may be nearer than what is matched.
void ShowScene::find_depths(const View& view, int height) noexcept {
  std::fill(depth_disparity_.begin(), depth_disparity_.end(), 0.0f);
  const int rows = static_cast<int>(depth_disparity_.size());
  const double farthest = view.stereo.f * view.stereo.baseline / (2 * config_.map.range + view.model.height_m);
  int last = rows;
  for (double d = farthest; d < 4 * view.most; d += std::max(0.02, d / 400)) {
    const int row = static_cast<int>(std::lround(view.floor.row(d))) + margin_;
    const int from = std::max(last >= rows ? row : std::min(last + 1, row), 0);
    for (int i = from; i <= std::min(row, rows - 1); ++i) depth_disparity_[static_cast<size_t>(i)] = static_cast<float>(d);
    last = row;
    if (row > height + margin_) break;
  }
}

void ShowScene::tint(const View& view, const Image& occupancy, const Image& surface, Image& out) const noexcept {
  const double cell = config_.map.cell, lean = view.plane.across / view.plane.down;
  const int rows = occupancy.spec.height, columns = occupancy.spec.width;
  const auto stands = static_cast<uint8_t>(Surface::obstacle);
  for (int v = 0; v < out.spec.height; ++v) {
    uint8_t* pixel = out.row<uint8_t>(v);
    const uint8_t* what = surface.row<uint8_t>(v);
    for (int u = 0; u < out.spec.width; ++u, pixel += 3) {
      const auto row = std::lround(v + lean * (u - view.stereo.cx)) + margin_;
      if (as_drawn(what[u]) == stands || row < 0 || row >= static_cast<long>(depth_disparity_.size())) continue;
      const double d = static_cast<double>(depth_disparity_[static_cast<size_t>(row)]);
      if (!(d > 0)) continue;
      const Point at = horizontal(view.stereo.point(u, v, d + view.stereo.cx_offset), view.model.pitch_rad, view.model.roll_rad);
      const int r = rows - 1 - static_cast<int>(std::floor(at.z / cell)), c = static_cast<int>(std::floor(at.x / cell + columns / 2.0));
      if (r < 0 || r >= rows || c < 0 || c >= columns) continue;
      const int percent = occupancy.row<int8_t>(r)[c];
      if (percent >= occupied_from) {
        mix(pixel, blocked, 6);
      } else if (percent >= 0 && percent <= free_up_to) {
        mix(pixel, free_ground, 5);
      }
      // Dotted along full metres aside.
      const double step = marks(config_.map.range), aside = at.x / step;
      const double pixel_wide = at.z / view.stereo.f / step;
      if (v / 4 % 2 == 0 && std::abs(aside - std::round(aside)) < 0.75 * pixel_wide) mix(pixel, white, 8);
    }
  }
}

void ShowScene::outline(const Image& surface, Image& out) const noexcept {
  const auto stands = static_cast<uint8_t>(Surface::obstacle), below = static_cast<uint8_t>(Surface::below);
  const int width = out.spec.width, height = out.spec.height;
  for (int v = 0; v < height; ++v) {
    const uint8_t *here = surface.row<uint8_t>(v), *over = surface.row<uint8_t>(std::max(v - 2, 0)),
                  *under = surface.row<uint8_t>(std::min(v + 2, height - 1));
    uint8_t* pixel = out.row<uint8_t>(v);
    for (int u = 0; u < width; ++u, pixel += 3) {
      const uint8_t what = as_drawn(here[u]);
      if (what != stands && what != below) continue;
      const bool rim = as_drawn(here[std::max(u - 2, 0)]) != what || as_drawn(here[std::min(u + 2, width - 1)]) != what ||
                       as_drawn(over[u]) != what || as_drawn(under[u]) != what;
      if (what == stands) {
        mix(pixel, blocked, rim ? 16 : 4);
      } else if (rim) {
        mix(pixel, hole, 12);
      }
    }
  }
}

void ShowScene::draw_ranges(const View& view, Image& out) const noexcept {
  line(view, view.plane.horizon(view.stereo), yellow, out);
  const double step = marks(config_.map.range), fb = view.stereo.f * view.stereo.baseline;
  for (double ahead = step; ahead <= config_.map.range + 1e-6; ahead += step) {
    const double depth = ahead * std::cos(view.model.pitch_rad) + view.model.height_m * std::sin(view.model.pitch_rad);
    if (!(depth > 0)) continue;
    line(view, view.floor.row(fb / depth), white, out);
    line(view, view.floor.row(fb / depth, config_.limit.max_height), blue, out);
  }
}

void ShowScene::line(const View& view, double row, const uint8_t (&colour)[3], Image& out) const noexcept {
  const double lean = view.plane.across / view.plane.down;
  for (int u = 0; u < out.spec.width; ++u) {
    if (view.held && u / 12 % 2) continue;
    const double at = std::floor(row - lean * (u - view.stereo.cx) + 0.5);
    if (at >= 0 && at < out.spec.height) mix(out.row<uint8_t>(static_cast<int>(at)) + 3 * u, colour, 10);
  }
}

}  // namespace vdisp
