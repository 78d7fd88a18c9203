// truth.cpp: the true disparity, objects, scene, floor line and map of a frame.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sim/truth.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "daemon/sim/truth_stage.h"

namespace vdisp::sim {
namespace {

class TrueDisparity final : public TruthStage {
  using TruthStage::TruthStage;
  ImageSpec make(const ImageSpec& camera) const override { return {Pixel::disparity16, 0, camera.width, camera.height}; }
  void fill(const TruthView& truth, Image& out) const noexcept override {
    out.camera = geometry();
    for (int v = 0; v < truth.height; ++v) {
      const float* depth = &truth.depth[static_cast<size_t>(v) * truth.width];
      int16_t* row = out.row<int16_t>(v);
      for (int u = 0; u < truth.width; ++u) row[u] = depth[u] > 0 ? saturated(16 * view_.disparity(depth[u])) : rejected(Rejected::outside);
    }
  }
};

class TrueObject final : public TruthStage {
  using TruthStage::TruthStage;
  ImageSpec make(const ImageSpec& camera) const override { return {Pixel::gray8, 0, camera.width, camera.height}; }
  void fill(const TruthView& truth, Image& out) const noexcept override {
    out.camera = geometry();
    for (int v = 0; v < truth.height; ++v)
      std::copy_n(&truth.object[static_cast<size_t>(v) * truth.width], truth.width, out.row<uint8_t>(v));
  }
};

class TrueScene final : public TruthStage {
  using TruthStage::TruthStage;
  ImageSpec make(const ImageSpec&) const override { return record_spec<TruthScene>(); }
  void fill(const TruthView& truth, Image& out) const noexcept override { make_record<TruthScene>(out) = truth.scene; }
};

class TrueFloor final : public TruthStage {
  using TruthStage::TruthStage;
  ImageSpec make(const ImageSpec&) const override { return {Pixel::line16, 0, static_cast<uint16_t>(16 * config_.image_source.ndisp), 1}; }
  /// In the column through the optical centre: with roll the floor is higher on one side by as much as it is lower on the other.
  FloorLine line(const GroundPlane& plane) const {
    const double pitch = std::atan(std::tan(plane.pitch) / std::cos(plane.roll));
    return floor_line(view_, plane.height * std::cos(pitch) / (std::cos(plane.pitch) * std::cos(plane.roll)), pitch);
  }
  void fill(const TruthView& truth, Image& out) const noexcept override {
    out.camera = geometry();
    const FloorLine level = line(truth.planes[0]), slope = line(truth.planes[1]);
    int16_t* row = out.row<int16_t>(0);
    for (int column = 0; column < out.spec.width; ++column) {
      const double d = column / 16.0 + config_.image_source.minDisparity - view_.cx_offset;
      if (truth.plane_count == 0) {
        row[column] = d > 0 ? saturated(simulator_.ground_row(view_.f * view_.baseline / d)) : line_none;
        continue;
      }
      const double a = level.row(d), b = slope.row(d);
      row[column] = saturated(truth.plane_count == 1 ? a : truth.rising ? std::min(a, b) : std::max(a, b));
    }
  }
};

class TrueMap final : public TruthGrid {
  using TruthGrid::TruthGrid;
  ImageSpec make(const ImageSpec&) const override { return grid_spec(Pixel::count16); }
  void fill(const TruthView& truth, Image& out) const noexcept override {
    out.grid = grid(truth);
    for (int row = 0; row < rows(); ++row) std::memset(out.row<int16_t>(row), 0, out.spec.stride());
    for (int v = 0; v < truth.height; ++v) {
      for (int u = 0; u < truth.width; ++u) {
        const size_t pixel = static_cast<size_t>(v) * truth.width + u;
        if (truth.depth[pixel] > 0 && truth.elevation[pixel] > config_.limit.max_height) count(truth, u, v, truth.depth[pixel], out);
      }
    }
  }
  void count(const TruthView& truth, int u, int v, double z, Image& out) const noexcept {
    const Point seen{(u - view_.cx) * z / view_.f, (v - view_.cy) * z / view_.f, z};
    const Point h = horizontal(seen, truth.scene.pitch_rad, truth.scene.roll_rad);
    const double row = rows() - 1 - std::floor(h.z / config_.map.cell), column = std::floor(h.x / config_.map.cell + columns() / 2.0);
    if (row < 0 || row >= rows() || column < 0 || column >= columns()) return;
    int16_t& cell = out.row<int16_t>(static_cast<int>(row))[static_cast<int>(column)];
    if (cell < INT16_MAX) ++cell;
  }
};

}  // namespace

void add_truth_stages(Driver& driver, Handle camera, Simulator& simulator, const Config& config) {
  driver.add("truth/disparity", std::make_unique<TrueDisparity>(simulator, config), {camera});
  driver.add("truth/object", std::make_unique<TrueObject>(simulator, config), {camera});
  driver.add("truth/scene", std::make_unique<TrueScene>(simulator, config), {camera});
  driver.add("truth/floor", std::make_unique<TrueFloor>(simulator, config), {camera});
  driver.add("truth/map", std::make_unique<TrueMap>(simulator, config), {camera});
  add_ground_truth(driver, camera, simulator, config);
  add_true_steering(driver, camera, simulator);
}

}  // namespace vdisp::sim
