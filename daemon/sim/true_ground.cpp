// true_ground.cpp: how high each pixel lies over the ground at its place, and what each cell of the map is.
// SPDX-License-Identifier: Apache-2.0
#include <array>

#include "daemon/geometry/frames.h"
#include "daemon/sim/truth_stage.h"

namespace vdisp::sim {
namespace {

class TrueHeight final : public TruthStage {
  using TruthStage::TruthStage;
  ImageSpec make(const ImageSpec& camera) const override { return {Pixel::height16, 0, camera.width, camera.height}; }
  void fill(const TruthView& truth, Image& out) const noexcept override {
    out.camera = geometry();
    for (int v = 0; v < truth.height; ++v) {
      const size_t first = static_cast<size_t>(v) * truth.width;
      int16_t* row = out.row<int16_t>(v);
      for (int u = 0; u < truth.width; ++u)
        row[u] = truth.depth[first + u] > 0 ? saturated(1000 * static_cast<double>(truth.elevation[first + u])) : height_unknown;
    }
  }
};

class TrueCells final : public TruthGrid {
  using TruthGrid::TruthGrid;
  ImageSpec make(const ImageSpec&) const override { return grid_spec(Pixel::gray8); }
  void fill(const TruthView& truth, Image& out) const noexcept override {
    out.grid = grid(truth);
    for (int row = 0; row < rows(); ++row)
      for (int column = 0; column < columns(); ++column) out.row<uint8_t>(row)[column] = static_cast<uint8_t>(judge(truth, row, column));
  }

  TruthCell judge(const TruthView& truth, int row, int column) const noexcept {
    constexpr int side = 5, samples = side * side;
    constexpr double step = 0.15;        // m: what drops less is no drop-off
    constexpr double least_rows = 0.25;  // level ground has more, 5 m ahead of the smallest picture
    int in_view = 0, seen = 0, dropped = 0, under = 0;
    for (int i = 0; i < samples; ++i) {
      // Up to the borders, so that an edge between two cells is in one of them.
      const double x = (column + i % side / (side - 1.0) - columns() / 2.0) * config_.map.cell,
                   z = (rows() - 1 - row + i / side / (side - 1.0)) * config_.map.cell;
      const Place place = simulator_.place(x, z);
      if (place.obstacle > config_.limit.max_height) return TruthCell::obstacle;
      under += place.overhang > 0;
      dropped += place.drop > step;
      const Sight sight = look(truth, {x, place.down, z});
      in_view += sight != Sight::outside;
      seen += sight == Sight::seen;
    }
    if (dropped > 0 && dropped < samples) return TruthCell::drop_off;
    if (in_view == 0) return TruthCell::outside;
    if (5 * seen < samples || rows_of(truth, row, column) < least_rows) return TruthCell::hidden;
    return under > 0 ? TruthCell::overhang : dropped > 0 ? TruthCell::below : TruthCell::free;
  }

  /// How many rows of the picture its ground takes, where nothing is before it; ground that falls away as the look does takes none.
  double rows_of(const TruthView& truth, int row, int column) const noexcept {
    const double x = (column + 0.5 - columns() / 2.0) * config_.map.cell, z = (rows() - 1 - row) * config_.map.cell;
    const auto v = [&](double ahead) {
      const Point c = camera({x, simulator_.place(x, ahead).down, ahead}, truth.scene.pitch_rad, truth.scene.roll_rad);
      return view_.cy + view_.f * c.y / std::max(c.z, 0.05);
    };
    return v(z) - v(z + config_.map.cell);
  }

  enum class Sight { outside, hidden, seen };
  /// Whether the left camera sees a point of the ground, given in frame h.
  Sight look(const TruthView& truth, const Point& h) const noexcept {
    const Point c = camera(h, truth.scene.pitch_rad, truth.scene.roll_rad);
    const double u = view_.cx + view_.f * c.x / c.z, v = view_.cy + view_.f * c.y / c.z;
    if (c.z < 0.05 || !(u >= 0 && u < truth.width && v >= 0 && v < truth.height)) return Sight::outside;
    // Over a pixel the depth of ground that is seen at a grazing angle changes by as much as this, or three times as much where it
    // slopes away.
    const double slack = 0.02 + 3 * c.z * c.z / (view_.f * truth.scene.height_m);
    const float there = truth.depth[static_cast<size_t>(v) * truth.width + static_cast<size_t>(u)];
    return there <= 0 || there > c.z - slack ? Sight::seen : Sight::hidden;
  }
};

}  // namespace

void add_ground_truth(Driver& driver, Handle camera, Simulator& simulator, const Config& config) {
  driver.add("truth/height", std::make_unique<TrueHeight>(simulator, config), {camera});
  driver.add("truth/map_cells", std::make_unique<TrueCells>(simulator, config), {camera});
}

}  // namespace vdisp::sim
