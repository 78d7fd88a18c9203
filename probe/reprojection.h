// reprojection.h: pixels of the left view and cells of the map, each seen from the other, by what the images of a frame say themselves.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "ipc/image.h"
#include "ipc/records.h"

namespace vdisp {

struct MapCell {
  int row, column;
  bool operator==(const MapCell&) const = default;
};

/// Pixels from..to, to excluded; and the disparities in px that floor has at the far and the near edge of the cell.
struct CellView {
  int left, right, top, bottom;
  double disparity_far, disparity_near;
  bool empty() const { return left >= right || top >= bottom; }
};

/// Pitch, roll, height and profile are the floor model's (docs/frames-of-reference.md), the camera that of the disparity's header.
/// Disparities are raw: cx_offset is taken from them here.
class Reprojection {
 public:
  /// `disparity` and `grid` are images of one frame; both and the model outlive this.
  Reprojection(const Image& disparity, const FloorModel& floor, const Image& grid);
  /// False: no calibration, no floor, or geometry that makes no sense; nothing else is to be asked then.
  bool possible() const { return possible_; }

  /// The cell in which what is seen at this pixel with this disparity (px) stands.
  std::optional<MapCell> cell_of(int column, int row, double disparity) const;
  /// Depth along the view, m; nothing at or beyond infinity.
  std::optional<double> depth(double disparity) const;
  /// What the plane of the floor has at this pixel, px; nothing above the horizon.
  std::optional<double> floor_disparity(int column, int row) const;
  /// Where the floor of a cell lies in the left view: rows from its far to its near edge, columns of a cell's width at its middle.
  CellView view_of(const MapCell& cell) const;

 private:
  struct Seen {
    double u, v, z;  // px, m along the view
  };
  double elevation(double ahead) const;
  Seen see(double x, double ahead) const;

  const Image &disparity_, &grid_;
  const FloorModel& floor_;
  double f_, cx_, cy_, baseline_, offset_, cell_, origin_row_, origin_column_;
  double cos_pitch_ = 1, sin_pitch_ = 0, cos_roll_ = 1, sin_roll_ = 0;
  bool possible_ = false;
};

}  // namespace vdisp
