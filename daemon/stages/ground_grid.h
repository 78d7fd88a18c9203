// ground_grid.h: the map's grid: its size, what its header says, and where pixels stand in it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "config/config.h"
#include "daemon/kernels/map.h"
#include "daemon/stages/projection.h"

namespace vdisp {

inline uint16_t grid_rows(const Config& config) { return static_cast<uint16_t>(std::lround(config.map.range / config.map.cell)); }
inline uint16_t grid_columns(const Config& config) { return static_cast<uint16_t>(std::lround(config.map.width / config.map.cell)); }

inline GridGeometry grid_geometry(const Config& config, const Image& disparity, double pitch) {
  const CameraGeometry& c = disparity.camera;
  const float along = c.f * static_cast<float>(std::cos(pitch));
  GridGeometry g{};
  g.cell = static_cast<float>(config.map.cell);
  g.origin_row = grid_rows(config);
  g.origin_column = static_cast<float>(grid_columns(config)) / 2;
  g.view_left = -c.cx / along;
  g.view_right = (static_cast<float>(disparity.spec.width) - c.cx) / along;
  g.min_count = static_cast<uint32_t>(config.map.minCount);
  g.pose_x = static_cast<float>(config.mounting.x);
  g.pose_y = static_cast<float>(config.mounting.y);
  g.pose_yaw = static_cast<float>(config.mounting.yaw);
  return g;
}

inline kernels::Ground ground_of(const Config& config, const Image& disparity, double pitch, double roll) {
  const StereoView view = stereo_view(disparity);
  return {view.f,          view.cx,        view.cy,        view.baseline,   view.cx_offset,    std::cos(pitch),
          std::sin(pitch), std::cos(roll), std::sin(roll), config.map.cell, grid_rows(config), grid_columns(config)};
}

}  // namespace vdisp
