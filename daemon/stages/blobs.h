// blobs.h: the obstacles of one frame: occupied cells that touch, and where the pixels that stand over them are.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>
#include <vector>

#include "config/config.h"
#include "daemon/core/processor.h"
#include "daemon/geometry/frames.h"
#include "daemon/stages/placement.h"
#include "ipc/records.h"

namespace vdisp {

/// What is seen of one obstacle: its visible front. The cells say which pixels belong together, the pixels where they are, finer than
/// cells.
struct Blob {
  double x = 0, y = 0;  ///< m, mean of its pixels, in the frame of the Placement
  double size_x = 0, size_y = 0, height = 0;
  double deviation = 0;  ///< m, of its place from frame to frame
  bool cut = false;      ///< reaches the border of the view or the map: its middle is not its own
};

/// The images of one frame that obstacles are made of, all of one size but for the grid.
struct ObstacleImages {
  const Image &occupancy, &reason, &standing, &height;
  const FloorModel& floor;
};

class Blobs {
 public:
  static constexpr int most = 64;
  /// Reserves for grids of this size. Throws FormatError where the images do not fit each other.
  void reserve(const ImageSpec& grid, const ImageSpec& pixels);
  /// The obstacles of a frame, valid until the next call.
  std::span<const Blob> find(const ObstacleImages& in, const Placement& placement) noexcept;

 private:
  struct Sum {
    int pixels = 0;
    double x = 0, y = 0, ahead = 0, least_x = 0, most_x = 0, least_y = 0, most_y = 0, height = 0;
    bool cut = false;
  };
  int label(const ObstacleImages& in) noexcept;
  void add_pixels(const ObstacleImages& in, const Placement& placement) noexcept;

  int rows_ = 0, columns_ = 0;
  int step_ = 1;                 // every so many-th pixel of every so many-th row is looked at
  std::vector<uint8_t> labels_;  // of the cells: 0 none, else the number of the blob from 1
  std::vector<int> open_;        // cells whose neighbours are still to be looked at
  std::array<Sum, most + 1> sums_;
  std::array<Blob, most> blobs_;
};

}  // namespace vdisp
