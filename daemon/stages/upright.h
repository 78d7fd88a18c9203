// upright.h: part of `surface`: what stands upright, whatever its height over the floor that is known.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "config/config.h"
#include "daemon/kernels/height.h"
#include "ipc/image.h"
#include "ipc/records.h"

namespace vdisp {

/// Height over the floor tells obstacles where the floor is known. Beyond a brow, or seen across a ditch, it is not: the floor told there
/// is only its continuation, and whatever crosses that at any height would be floor. A floor recedes from row to row, and a wall does not:
/// what rises by max_height at one distance is no floor.
class Upright {
 public:
  explicit Upright(const Config& config) : config_(config) {}
  void prepare(const ImageSpec& disparity);
  /// The pixels of such things that are floor, or under it, by their height become obstacles; and those of a wall that begins behind an
  /// edge of the floor and ends level with it, where the floor goes on, are under it: the far side of a ditch. `surfaces`: height16,
  /// surface, obstacles and overhangs of the disparity image, as the stage has them.
  void mark(const Image& disparity, const FloorModel& model, std::span<Image* const> surfaces) noexcept;

 private:
  struct Sample {
    float ahead, up, depth;  // m along the ground, over the plane of the floor, and along the view
    int row;
    int16_t rises_after, disparity;  // samples
  };
  /// Of a disparity: m along the view, and after how many samples what is no floor has risen.
  struct Range {
    float depth = 0;
    int16_t rises_after = 1;
  };
  /// Of a frame.
  struct Scale {
    float focal, noise, recedes;  // px; m of distance that disparities vary by, and that floor recedes by from row to row, at 1 m
    float rise, dents;            // m that a px of disparity is in height, on floor at 1 m; m that dents of the floor may be deep
  };
  struct Marks {
    const Image &disparity, &height;
    Image &surface, &obstacles;
  };
  Range range_of(float depth) const;
  /// How deep the dents of the floor nearer than that may be, by how uneven it is, m.
  float dents(const Marks& marks, int least_disparity) const noexcept;
  /// Takes every `across`th column of every `down`th row, from below.
  void gather(const Image& disparity) noexcept;
  /// What an image column shows, from below.
  std::span<const Sample> look(const Image& disparity, const FloorModel& model, int number) noexcept;
  float noise(const Sample& of) const { return scale_.noise * of.depth * of.depth; }
  /// By how much the distance of a thing that stands there may vary, m.
  float depth(const Sample& of, float leans) const;
  /// By how much something there seems to rise more where the disparity of its foot is so far off, m.
  float rise_of(float px, const Sample& at) const;
  float level() const;  // m: what is no higher is level
  bool gap(const Sample& below, const Sample& above) const;
  /// The first sample that is not at the distance of this one any more.
  size_t run_from(std::span<const Sample> samples, size_t first, float leans) const noexcept;
  /// Where the floor before it ends, if its foot is hidden; else null.
  const Sample* edge_before(std::span<const Sample> samples, size_t first) const noexcept;
  /// Behind its top, level with it.
  bool floor_goes_on(std::span<const Sample> samples, size_t end) const noexcept;
  /// What rises, at its top: in how many columns beside each other, whether it is the far wall of a ditch, and whether its foot is seen.
  struct Rise {
    float ahead, up;
    int columns;
    bool ditch, standing;
  };
  /// The same in the column before; null where that shows none.
  const Rise* beside(const Sample& top, bool standing) const;
  void note(const Sample& top, const Rise* same, bool ditch, bool standing) noexcept;
  /// What rises from `first` to `end` behind the edge is the far wall of a ditch.
  bool is_ditch(std::span<const Sample> samples, size_t first, size_t end, const Sample& edge, const Rise* same) const noexcept;
  void mark_column(const Marks& marks, std::span<const Sample> samples, int column) noexcept;
  void mark_run(const Marks& marks, std::span<const Sample> run, kernels::Surface is, bool hidden, int column) const noexcept;

  const Config& config_;
  std::vector<int16_t> gathered_;  // by column and row
  std::vector<Range> ranges_;      // by column of a v-disparity
  std::vector<Sample> samples_;
  std::vector<Rise> now_, before_;  // in this column and the one before
  Scale scale_{};
  int columns_ = 0, rows_ = 0;
  int across_ = 4, down_ = 4;  // px from sample to sample
};

}  // namespace vdisp
