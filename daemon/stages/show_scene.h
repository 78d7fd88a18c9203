// show_scene.h: display `show_scene`: floor, limit, free space and obstacles drawn into the left view.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "config/config.h"
#include "daemon/core/processor.h"
#include "daemon/stages/ground_grid.h"
#include "daemon/stages/local_floor.h"

namespace vdisp {

/// The left view, surface (gray8), occupancy (int8) and FloorModel to rgb8:
///   green          ground of cells that are free
///   red            ground of cells that are obstacles or drop-offs; pixels of obstacles, their outline full
///   violet         outline of what lies below the floor
///   white, blue    the local floor at each full metre ahead (each 5 or 10 m where the map reaches far), and the limit over it; dotted:
///   each
///                  full metre aside
///   yellow         horizon of the floor's plane
/// No tint: unknown. Where the floor is held, the lines are broken.
class ShowScene final : public ImageProcessor {
 public:
  explicit ShowScene(const Config& config) : config_(config) {}
  std::vector<ImageSpec> check(std::span<const ImageSpec> in) override;
  Outcome process(std::span<const Image* const> in, std::span<Image* const> out) noexcept override;

 private:
  struct View {
    StereoView stereo;
    LocalFloor floor;
    FloorPlane plane;
    const FloorModel& model;
    double most;  // px, of the search
    bool held;
  };
  void find_depths(const View& view, int height) noexcept;
  void tint(const View& view, const Image& occupancy, const Image& surface, Image& out) const noexcept;
  void outline(const Image& surface, Image& out) const noexcept;
  void draw_ranges(const View& view, Image& out) const noexcept;
  /// A line over all columns that passes the middle column at this row and leans as the floor does.
  void line(const View& view, double row, const uint8_t (&colour)[3], Image& out) const noexcept;

  const Config& config_;
  std::vector<float> depth_disparity_;  // true disparity of the local floor by its row in the middle column, from -margin_ on; 0: none
  int margin_ = 0;
};

}  // namespace vdisp
