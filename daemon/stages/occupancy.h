// occupancy.h: stages `occupancy` and `reason`: what each cell of the ground is, how sure that is, and why.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "config/config.h"
#include "daemon/core/processor.h"
#include "daemon/stages/ground_grid.h"
#include "daemon/stages/local_floor.h"
#include "daemon/stages/machine.h"

namespace vdisp {

/// Disparity, surface (gray8), height16, obstacles and overhangs (disparity16), FloorModel and the left view to the map's grid twice: int8,
/// -1 unknown, else 0..100; and gray8, the CellReason.
///
/// Obstacles: pixels that stand over a cell and its two neighbours ahead and behind, against those that an object of half max_height over
/// the limit and a cell wide would give there, so that the same object counts the same at any range: 1 - exp(-seen / (0.24 expected)).
/// Floor (paper 5.4): the cell is looked up in the image, through the local floor, and what is seen there tallied: floor at the cell's own
/// depth, something nearer (occluded), something farther, or no disparity and why. Joined: an obstacle beats floor; no floor is seen in the
/// shadow of an obstacle, which is as long as one of max_height throws; where floor leads up to a cell through which something is seen that
/// lies lower than the floor would go on, or the far side of a ditch, a drop-off begins, if in as many columns as a few windows are wide,
/// at one side or both of what stands before it; it goes on along its line, and for a cell behind what hides the rest; a small patch of
/// floor by itself is a false match, or the top of something behind a crest; floor up to half a window before what has no texture may be
/// the window's; a cell that shows less than 0.4 of floor leads on to others, and is not free itself; an obstacle in one cell alone takes
/// twice the pixels, and a narrow one of hardly more pixels than a window of the matcher, so far off that the least object has no more, or
/// with floor under it, stays suspected; what is none of this is unknown.
class Occupancy final : public ImageProcessor {
 public:
  Occupancy(Machine& machine, const Config& config) : machine_(machine), config_(config) {}
  std::vector<ImageSpec> check(std::span<const ImageSpec> in) override;
  Outcome process(std::span<const Image* const> in, std::span<Image* const> out) noexcept override;

 private:
  static constexpr int most_samples = 6;                        // of a cell, each way
  static constexpr double depth_off = 1.0, depth_share = 0.03;  // px, and of the disparity: as deep as the cell
  struct Tally {
    int all = 0, floor = 0, nearer = 0, wall = 0;
    struct Through {
      double count = 0, height = 0, ahead = 0;  // sums of m over the plane and along the ground
    } beyond, lower;                            // on ground or a far wall; upright and lower than the floor, of a foot that is hidden
    std::array<int, cell_reasons> why{};
  };
  struct Inputs {
    const Image &disparity, &surface, &height, &left;
    StereoView view;
    LocalFloor floor;
    PlanePose pose;
    ToCamera to_camera;
    double nearest;  // true disparity, px, beyond which nothing is matched
  };
  /// What is seen through a cell, in the mean; ahead = 0: nothing. `wall`: the far side of a ditch, hardly lower. `sure`: not only by what
  /// is upright and hides its foot, which may as well stand behind a crest.
  struct Beyond {
    float height, ahead;
    bool wall, sure;
  };
  struct Box {
    double left, right, top, bottom, d_far, d_near;  // px
  };
  Box box(const Inputs& in, int row, int column) const noexcept;
  void look(const Inputs& in, const Box& box, Tally& tally) const noexcept;
  void refuse_untextured(const Inputs& in, const Box& box, Tally& tally) const noexcept;
  /// Pixels of the least object that stands in a cell; which part of it lies where the picture can be matched; and how many pixels that is.
  double least_object(const Inputs& in, const Box& box) const noexcept;
  double part_in_view(const Inputs& in, const Box& box) const noexcept;
  double expected(const Inputs& in, const Box& box) const noexcept;
  int seen(int row, int column) const noexcept;
  static Beyond what_is_beyond(const Tally& tally) noexcept;
  void judge(const Inputs& in, int row, int column, Image& occupancy, Image& reason) noexcept;
  double windows(const Inputs& in, int row) const noexcept;
  template <class Is>
  void find_patch(int begin, Is is) noexcept;
  bool may_be_false(const Inputs& in, const Image& reason) noexcept;
  bool hides_no_floor(const Inputs& in, int cell, const Image& reason) const noexcept;
  void doubt_lone(const Inputs& in, Image& occupancy, const Image& reason) noexcept;
  void shade(const Inputs& in, Image& occupancy, Image& reason) const noexcept;
  int column_on_ray(int row, int column, int step) const noexcept;
  bool is_hidden(int row, int column) const noexcept;
  void drop_offs(const Inputs& in, Image& occupancy, Image& reason) noexcept;
  /// Of an edge whose row in this column is `line`: whether floor is seen behind it.
  bool floor_behind(int line, int column, const Image& reason) const noexcept;
  /// The same: the row where the floor ends there, -1: it does not, or what is behind is known; and tells a drop-off in that row.
  int end_of_floor(int line, int column, const Image& occupancy, const Image& reason) const noexcept;
  void tell_end(int line, int column, Image& occupancy, Image& reason) const noexcept;
  void tell_hidden(int line, int column, Image& occupancy, Image& reason) const noexcept;
  void join_edges(Image& occupancy, Image& reason) const noexcept;
  int edge_row(int column) const noexcept { return column < 0 || column >= columns_ ? -1 : edges_[static_cast<size_t>(column)]; }
  /// Where an edge goes on from its column `end` to one side, by so many rows in so many columns.
  struct Line {
    int end, side, rise, run;
  };
  struct Followed {
    int columns = 0, ends = 0;  // up to where the line can be that of an edge; in how many of these the floor ends on it
  };
  int row_on(const Line& line, int on) const noexcept { return edge_row(line.end) + line.rise * on / line.run; }
  Followed follow(const Line& line, const Image& occupancy, const Image& reason) const noexcept;
  bool find_line(const Image& occupancy, const Image& reason, Line& line) const noexcept;
  void extend_edges(Image& occupancy, Image& reason) const noexcept;
  int edge_near(int row, int column, const Image& reason) const noexcept;
  int edge_behind(int row, int column, int side, const Image& occupancy, const Image& reason) const noexcept;
  int columns_of_edge(int row, int column, int most, const Image& occupancy, const Image& reason) const noexcept;
  void refuse_lone_edges(const Inputs& in, Image& occupancy, Image& reason) noexcept;
  void islands(Image& occupancy, Image& reason) noexcept;
  void refuse_partly(Image& occupancy, Image& reason) const noexcept;

  Machine& machine_;
  const Config& config_;
  kernels::GroundScratch scratch_;
  std::vector<int16_t> all_limit_, obstacles_, overhangs_;  // limit that everything is above; counts by cell
  std::vector<Beyond> beyond_;
  std::vector<int> edges_, island_, counted_;      // by column: the row where a drop-off begins, -1: none; cells of one patch; those beside
  std::vector<uint8_t> known_, whole_, standing_;  // marks; shows hardly anything but floor; an obstacle, before any is doubted
  std::vector<CellReason> partly_;                 // of a cell that shows a little floor: what else it shows; floor: no such cell
  int rows_ = 0, columns_ = 0;
};

}  // namespace vdisp
