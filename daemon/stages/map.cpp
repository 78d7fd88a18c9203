// map.cpp: each obstacle pixel is put into the cell it stands over.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/map.h"

#include <cmath>
#include <cstring>

#include "daemon/stages/projection.h"

namespace vdisp {

std::vector<ImageSpec> Map::check(std::span<const ImageSpec> in) {
  if (in.size() != 3) throw FormatError("takes disparity, limit and floor model, was given " + std::to_string(in.size()) + " images");
  require(in[0], Pixel::disparity16, "the disparity");
  require(in[1], Pixel::line16, "the limit");
  require(in[2], Pixel::record, "the floor model");
  const auto& m = config_.map;
  scratch_ = kernels::GroundScratch(in[0].width, in[1].width);
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

kernels::Ground Map::ground(const Image& disparity, double pitch, const ImageSpec& spec) const {
  const StereoView view = stereo_view(disparity);
  const double roll = config_.mounting.roll;
  return {view.f,          view.cx,        view.cy,        view.baseline,    view.cx_offset, std::cos(pitch),
          std::sin(pitch), std::cos(roll), std::sin(roll), config_.map.cell, spec.height,    spec.width};
}

Outcome Map::process(std::span<const Image* const> in, std::span<Image* const> out) noexcept {
  const Image &disparity = *in[0], &limit = *in[1];
  Image& map = *out[0];
  const double pitch = pitch_in_use(config_, *in[2]->row<FloorModel>(0));
  map.reason = no_metres(disparity, pitch);
  if (map.reason != Reason::none) return Outcome::invalid;
  map.grid = grid(disparity, pitch, map.spec);
  for (int row = 0; row < map.spec.height; ++row) std::memset(map.row<int16_t>(row), 0, map.spec.stride());

  machine_.kernels.count_cells(plane<int16_t>(disparity), search_of(disparity.camera, limit.spec.width), limit.row<int16_t>(0),
                               ground(disparity, pitch, map.spec), plane<int16_t>(map), scratch_);
  return Outcome::valid;
}

}  // namespace vdisp
