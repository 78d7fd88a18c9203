// surfaces.cpp: tables by disparity, then row by row.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/surfaces.h"

#include "daemon/stages/limits_mm.h"
#include "daemon/stages/local_floor.h"
#include "daemon/stages/projection.h"

namespace vdisp {
namespace {

constexpr int least_band = 32;  // rows

// Kernels know no images: the codes on the wire are theirs.
constexpr bool same(kernels::Surface a, Surface b) { return static_cast<uint8_t>(a) == static_cast<uint8_t>(b); }
static_assert(same(kernels::Surface::none, Surface::none) && same(kernels::Surface::floor, Surface::floor) &&
              same(kernels::Surface::obstacle, Surface::obstacle) && same(kernels::Surface::overhang, Surface::overhang) &&
              same(kernels::Surface::below, Surface::below) && same(kernels::Surface::filled, Surface::filled));

}  // namespace

std::vector<ImageSpec> Surfaces::check(std::span<const ImageSpec> in) {
  if (in.size() != 3)
    throw FormatError("takes the disparity, the floor model and the left view, was given " + std::to_string(in.size()) + " images");
  require(in[0], Pixel::disparity16, "the disparity");
  require(in[1], Pixel::record, "the floor model");
  require(in[2], Pixel::gray8, "the left view");
  require_same_size(in[0], in[2]);
  const size_t columns = 16 * static_cast<size_t>(config_.image_source.ndisp) + 64;
  heights_.assign(columns, kernels::HeightOf{});
  upright_.prepare(in[0]);
  rising_.prepare(in[0]);
  filling_.prepare(in[0]);
  const uint16_t width = in[0].width, height = in[0].height;
  return {{Pixel::height16, 0, width, height},
          {Pixel::gray8, 0, width, height},
          {Pixel::disparity16, 0, width, height},
          {Pixel::disparity16, 0, width, height}};
}

Outcome Surfaces::process(std::span<const Image* const> in, std::span<Image* const> out) noexcept {
  const Image& disparity = *in[0];
  const FloorModel& model = *in[1]->row<FloorModel>(0);
  out[0]->reason = no_metres(disparity, model.pitch_rad);
  if (out[0]->reason != Reason::none) return Outcome::invalid;
  const StereoView view = stereo_view(disparity);
  const LocalFloor floor(model, view);
  const FloorPlane plane = floor.plane();
  const kernels::Search search = search_of(disparity.camera, 16 * disparity.camera.disparities);
  const double camera_mm = 1000 * model.height_m;
  // RisingGround looks up what is a little nearer, too.
  const int most = std::min<int>(search.columns + 16, static_cast<int>(heights_.size()));
  for (int column = search.least - search.first; column < most; ++column) {
    const double d = true_disparity(disparity.camera, column);
    heights_[static_cast<size_t>(column)] = {static_cast<float>(camera_mm / d), static_cast<float>(1000 * floor.elevation_of(d))};
  }
  const kernels::HeightTable table = heights_.data();
  const LimitsMm limits(config_);
  for (Image* image : out) image->flags |= in[1]->flags & flag_held;
  machine_.bands.run(disparity.spec.height, least_band, [&](int first, int last, int) {
    kernels::HeightRow row{static_cast<float>(camera_mm), 0, static_cast<float>(plane.across), limits.step, limits.clearance, limits.hole};
    for (int v = first; v < last; ++v) {
      row.first = static_cast<float>(plane.at(0, v, view));
      machine_.kernels.measure_heights(disparity.row<int16_t>(v), disparity.spec.width, search, row, table,
                                       {out[0]->row<int16_t>(v), out[1]->row<uint8_t>(v), out[2]->row<int16_t>(v), out[3]->row<int16_t>(v),
                                        height_unknown, rejected(Rejected::matcher)});
    }
  });
  upright_.mark(disparity, model, out);
  rising_.mark(disparity, model, table, out);
  filling_.fill(disparity, *in[2], model, table, out);
  return Outcome::valid;
}

}  // namespace vdisp
