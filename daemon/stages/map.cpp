// map.cpp: each obstacle pixel is put into the cell it stands over.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/map.h"

#include <cmath>
#include <cstring>

#include "daemon/stages/projection.h"
#include "daemon/stages/show_obstacle.h"

namespace vdisp {

std::vector<ImageSpec> Map::check(std::span<const ImageSpec> in) {
  if (in.size() != 3) throw FormatError("takes disparity, limit and floor model, was given " + std::to_string(in.size()) + " images");
  require(in[0], Pixel::disparity16, "the disparity");
  require(in[1], Pixel::line16, "the limit");
  require(in[2], Pixel::record, "the floor model");
  const auto& m = config_.map;
  return {{Pixel::count16, 0, static_cast<uint16_t>(std::lround(m.width / m.cell)), static_cast<uint16_t>(std::lround(m.range / m.cell))}};
}

GridGeometry Map::grid(const Image& disparity, double pitch, const ImageSpec& spec) const {
  const CameraGeometry& c = disparity.camera;
  const auto& mounting = config_.mounting;
  const float along = c.f * static_cast<float>(std::cos(pitch));
  GridGeometry g{};
  g.cell = static_cast<float>(config_.map.cell);
  g.origin_row = spec.height;
  g.origin_column = static_cast<float>(spec.width) / 2;
  g.view_left = -c.cx / along;
  g.view_right = (static_cast<float>(disparity.spec.width) - c.cx) / along;
  g.min_count = static_cast<uint32_t>(config_.map.minCount);
  g.pose_x = static_cast<float>(mounting.x);
  g.pose_y = static_cast<float>(mounting.y);
  g.pose_yaw = static_cast<float>(mounting.yaw);
  return g;
}

Outcome Map::process(std::span<const Image* const> in, std::span<Image* const> out) noexcept {
  const Image &disparity = *in[0], &limit = *in[1];
  Image& map = *out[0];
  const double pitch = pitch_in_use(config_, *in[2]->row<FloorModel>(0));
  map.reason = no_metres(disparity, pitch);
  if (map.reason != Reason::none) return Outcome::invalid;
  map.grid = grid(disparity, pitch, map.spec);
  for (int row = 0; row < map.spec.height; ++row) std::memset(map.row<int16_t>(row), 0, map.spec.stride());

  const StereoView view = stereo_view(disparity);
  const int16_t* limit_rows = limit.row<int16_t>(0);
  const double cell = config_.map.cell, middle = map.spec.width / 2.0, roll = config_.mounting.roll;
  for (int v = 0; v < disparity.spec.height; ++v) {
    const int16_t* d = disparity.row<int16_t>(v);
    for (int u = 0; u < disparity.spec.width; ++u) {
      if (!above_limit(disparity.camera, limit_rows, v, d[u])) continue;
      const Point h = horizontal(view.point(u, v, d[u] / 16.0), pitch, roll);
      const double row = map.spec.height - 1 - std::floor(h.z / cell), column = std::floor(h.x / cell + middle);
      if (!(row >= 0 && row < map.spec.height && column >= 0 && column < map.spec.width)) continue;
      int16_t& count = map.row<int16_t>(static_cast<int>(row))[static_cast<int>(column)];
      if (count < INT16_MAX) ++count;
    }
  }
  return Outcome::valid;
}

}  // namespace vdisp
