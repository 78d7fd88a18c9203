// plane_floor.h: stages `floor` and `floor_model` for [Floor] model = plane | profile: found, held or lost, and why.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "daemon/core/processor.h"
#include "daemon/stages/floor_profile.h"
#include "daemon/stages/gravity.h"
#include "daemon/stages/plane_search.h"

namespace vdisp {

/// disparity16, the left view (gray8) and the IMU's record, which may be blind, to line16 (row of the local floor in the middle column for
/// each column of the v-disparity, not clipped) and the record FloorModel.
///
/// found: measured in this frame. held: not found, and the last one found is taken, for at most `hold` s, and never where there is no
/// light, no texture, or nothing that matches. lost: neither; blind, with the reason. With an IMU the last floor is taken to lie as the
/// camera turned since (gravity.h), both where it is held and where the search begins.
///
/// Where ten frames one after the other agreed with height, pitch and roll of [mounting] it is trusted: only its ground, and ramps up to
/// [Floor] maxSlope, are floors then. A wall that fills the picture is none, and the floor is lost there. Trust ends where [mounting] is
/// changed, and after half a minute without a floor: a camera that was knocked is measured anew, and told.
class PlaneFloor final : public ImageProcessor {
 public:
  PlaneFloor(Machine& machine, const Config& config)
      : config_(config), profiles_(config.floor.model == "profile"), search_(machine, config), profile_(config), gravity_(config) {}
  std::vector<ImageSpec> check(std::span<const ImageSpec> in) override;
  Outcome process(std::span<const Image* const> in, std::span<Image* const> out) noexcept override;

  void begin_anew() noexcept override;

 private:
  /// Why nothing can be seen in these images; none if something can.
  Reason blindness(const Image& disparity, const Image& left) const noexcept;
  bool find(const Image& disparity, FloorModel& model) noexcept;
  void describe(const StereoView& view, const PlaneSearch::Found& found, FloorModel& model) noexcept;
  /// Of a model the plane, and its pose where metres are known.
  static void lay(const FloorPlane& plane, const StereoView& view, FloorModel& model) noexcept;
  void steady(const Image& disparity, FloorModel& model) noexcept;
  /// What gravity says, beside what the floor says.
  void weigh(const FloorModel& before, double part, FloorModel& model) noexcept;
  /// The last floor as it should lie now; none where nothing is known of that.
  std::optional<FloorPlane> predicted(const StereoView& view) const noexcept;
  bool hold(const Image& disparity, Reason why, FloorModel& model) noexcept;
  /// Forgets its trust where [mounting] was changed, or no floor was found for long.
  bool trusts_mounting(const Image& disparity) noexcept;
  bool agrees_with_mounting(const FloorModel& model) const noexcept;

  const Config& config_;
  bool profiles_;
  PlaneSearch search_;
  FloorProfile profile_;
  Gravity gravity_;
  std::optional<FloorModel> last_;  // found
  int64_t last_ns_ = 0;
  struct Trust {
    double height = 0, pitch = 0, roll = 0;  // [mounting] as it was
    int frames = 0;                          // agreed with it one after the other
  } trust_;
};

}  // namespace vdisp
