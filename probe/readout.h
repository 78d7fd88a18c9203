// readout.h: images in words: the value under the cursor with its metres, records as lines of text, the obstacles of a map.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ipc/image.h"

namespace vdisp {

/// "gray8 640x480"
std::string spec_words(const ImageSpec& spec);

/// What lies at this column and row of a picture stage, in one line; empty outside the image.
std::string read_out(std::string_view topic, const Image& image, int column, int row);

/// A record as "name  value" lines.
std::vector<std::string> record_text(const Image& image);

/// A place on the ground: x to the right of the camera, z ahead.
struct Place {
  double x, z;
  double distance() const;
  double bearing_deg() const;  ///< positive to the right
};
/// False for geometry that no map can have: nothing is drawn by it.
bool usable(const GridGeometry& grid);
/// The rover in a grid of the odometry frame.
Place rover_of(const GridGeometry& grid);
/// Centre of a cell.
Place place_of(const GridGeometry& grid, double column, double row);
/// The obstacle cell nearest to the camera, if any. The image is a valid map.
std::optional<Place> nearest_obstacle(const Image& map);
bool is_obstacle(const GridGeometry& grid, int16_t count);
/// True where the cell's centre lies in the camera's view.
bool in_view(const GridGeometry& grid, int column, int row);

}  // namespace vdisp
