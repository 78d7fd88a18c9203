// filling.h: part of `surface`: even surfaces between matched edges (paper 5.3).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "config/config.h"
#include "daemon/geometry/floor_plane.h"
#include "daemon/kernels/height.h"
#include "ipc/image.h"
#include "ipc/records.h"

namespace vdisp {

/// What has no texture has disparities along its edges alone. Its inside is filled where the left view shows it to be one surface: even
/// (no edge in it), shut off by edges above and below, not wider than [Limit obstacle] fill, its left and right edges each on a straight
/// line of disparities from row to row, obstacles in part, and both standing on the floor where the surface ends. Between two posts what
/// is even ends elsewhere than the posts do, or does not end; it is left alone, as is all that the view's border cuts. What is filled is
/// an obstacle, or nothing: never floor.
class Filling {
 public:
  explicit Filling(const Config& config) : config_(config) {}
  void prepare(const ImageSpec& disparity);
  /// `table`: of the frame, for all that search_of() has. `surfaces`: height16, surface and obstacles of the disparity image, as the stage
  /// has them so far.
  void fill(const Image& disparity, const Image& left, const FloorModel& model, const kernels::HeightTable& table,
            std::span<Image* const> surfaces) noexcept;

 private:
  /// One border of a run: the match nearest to it in its row.
  struct Border {
    int16_t column, disparity;  // px, and 1/16 px; 0: none near
    bool obstacle;
  };
  /// Even samples of a row, from..to - 1.
  struct Run {
    int16_t row, from, to;
    int16_t above;  // the run it goes on from; -1: none
    bool goes_on, open;
    float mean;  // grey level
    Border left, right;
  };
  /// disparity = at + slope * row, in 1/16 px, of one side from its first row to its last, px, where its match and
  /// the even samples end.
  struct Edge {
    float at, slope;
    int first, last, column_last, end_last;
    float of(int row) const { return at + slope * static_cast<float>(row); }
    bool has(const Border& border, int row) const {
      constexpr float within = 16;  // 1/16 px
      return border.disparity > 0 && std::abs(static_cast<float>(border.disparity) - of(row)) <= within;
    }
  };
  struct Frame {
    const Image &disparity, &left, &surface;
    StereoView view;
    FloorPlane plane;
    float camera_mm;
    kernels::Search search;
    kernels::HeightTable table;
  };
  /// mm over the local floor of what has this disparity, 1/16 px; NaN: not in the search.
  static float height(const Frame& frame, int column, int row, float disparity);
  int sampled_row(int number) const { return number * down_ + down_ / 2; }
  void find_runs(const Frame& frame, int number) noexcept;
  Border border(const Frame& frame, int row, int column, int step) const noexcept;
  void link(size_t first_above, size_t first, size_t end) noexcept;
  bool edge_of(const Frame& frame, std::span<const Run> surface, Border Run::*side, int16_t Run::*end, Edge& edge) const noexcept;
  void fill_surface(const Frame& frame, std::span<const Run> surface, std::span<Image* const> out) const noexcept;
  void fill_row(const Frame& frame, int row, int first, int last, float disparity, float per_column,
                std::span<Image* const> out) const noexcept;

  const Config& config_;
  std::vector<Run> runs_, surface_;  // of the image, by rows; of one surface, from below
  int columns_ = 0, rows_ = 0;
  int across_ = 4, down_ = 4;  // px from sample to sample
};

}  // namespace vdisp
