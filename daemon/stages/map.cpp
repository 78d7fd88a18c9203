// map.cpp: each obstacle pixel is put into the cell it stands over.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/map.h"

#include <cmath>
#include <cstring>

#include "daemon/stages/ground_grid.h"

namespace vdisp {

std::vector<ImageSpec> Map::check(std::span<const ImageSpec> in) {
  if (in.size() != 2 && in.size() != 3)
    throw FormatError("takes disparity, limit and floor model, or obstacles and floor model, was given " + std::to_string(in.size()) +
                      " images");
  require(in[0], Pixel::disparity16, "the disparity");
  if (in.size() == 3) require(in[1], Pixel::line16, "the limit");
  require(in.back(), Pixel::record, "the floor model");
  const size_t columns = in.size() == 3 ? in[1].width : 16 * static_cast<size_t>(config_.image_source.ndisp);
  everything_.assign(columns, INT16_MAX);
  scratch_ = kernels::GroundScratch(in[0].width, static_cast<int>(columns));
  return {{Pixel::count16, 0, grid_columns(config_), grid_rows(config_)}};
}

Outcome Map::process(std::span<const Image* const> in, std::span<Image* const> out) noexcept {
  const Image& disparity = *in[0];
  Image& map = *out[0];
  const FloorModel& model = *in.back()->row<FloorModel>(0);
  const int16_t* limit = in.size() == 3 ? in[1]->row<int16_t>(0) : everything_.data();
  const double pitch = pitch_in_use(config_, model), roll = measures_roll(model) ? model.roll_rad : config_.mounting.roll;
  map.reason = no_metres(disparity, pitch);
  if (map.reason != Reason::none) return Outcome::invalid;
  map.grid = grid_geometry(config_, disparity, pitch);
  for (int row = 0; row < map.spec.height; ++row) std::memset(map.row<int16_t>(row), 0, map.spec.stride());

  machine_.kernels.count_cells(plane<int16_t>(disparity), search_of(disparity.camera, static_cast<int>(everything_.size())), limit,
                               ground_of(config_, disparity, pitch, roll), plane<int16_t>(map), scratch_);
  return Outcome::valid;
}

}  // namespace vdisp
