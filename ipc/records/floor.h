// floor.h: the floor of a frame.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "record.h"

namespace vdisp {

enum class FloorState : uint32_t { lost = 0, found = 1, held = 2 };
enum class FloorKind : uint32_t { line = 1, plane = 2, profile = 3 };

/// What became of the sample of `in/imu` in the search for the floor.
enum class ImuUse : uint32_t {
  none = 0,          ///< there is none
  used = 1,          ///< it tells how the camera turned since the last floor
  settling = 2,      ///< the first one, or [mounting] pitch is not known yet: nothing to compare with
  late = 3,          ///< older than 0.1 s
  accelerating = 4,  ///< what it measures is more or less than gravity
  jumped = 5,        ///< it turns faster than a rover can
  askew = 6,         ///< it lies on its side or upside down
  contradicts = 7,   ///< the images show a floor that turns otherwise
};

/// The floor of one frame: true disparity d' = (v - b) / (16 a) + tilt (u - cx) at column u, row v, px (0 at infinity,
/// CameraGeometry::cx_offset). The line knows no tilt. A profile stands on its plane: the local floor is higher than it by profile_m.
struct FloorModel {
  static constexpr RecordType type = RecordType::floor_model;
  static constexpr uint16_t version = 4;
  static constexpr uint32_t profile_capacity = 64;
  RecordHeader header;
  FloorState state;
  FloorKind model;
  double a;                   ///< rows per column of the v-disparity, that is per 1/16 px; 0 when lost
  double b;                   ///< row at d' = 0 in the middle column, cx
  double pitch_rad;           ///< positive: the camera looks down; NaN without calibration or floor
  double roll_rad;            ///< positive: right side low; NaN where the model does not measure it
  double height_m;            ///< of the camera over the floor; NaN without calibration or floor
  double confidence;          ///< 0..1: line: share of the votes that lie on it; plane: of what is on it or beyond it, and of a good number
  Reason reason;              ///< why lost or held, or what could not be measured
  uint32_t points;            ///< points that lie on the floor; how many there were, when lost
  uint32_t mounting_differs;  ///< 1: pitch or height lie outside the tolerances of [mounting]
  uint32_t profile_count;     ///< elements of profile_m; 0: none
  double tilt;                ///< px of disparity per column
  double steady_pitch_rad, steady_roll_rad, steady_height_m;  ///< filtered over some seconds; NaN where not known
  double held_s;                                              ///< age of a held floor
  float profile_start_m, profile_step_m;                      ///< ground distance of profile_m[0], and from one to the next
  float profile_m[profile_capacity];                          ///< height of the local floor over the plane
  double gravity_pitch_rad, gravity_roll_rad;  ///< of the camera against the vertical, by the IMU, filtered likewise; NaN: not known
  ImuUse imu;
  uint32_t
      gravity_differs;    ///< 1: filtered, they are not those over the floor, by more than [mounting] pitchTolerance: a slope, or a fault
  uint32_t profile_seen;  ///< elements of profile_m up to the last that shows floor; beyond it the floor is taken to go on level
  uint32_t reserved;      ///< 0
};

static_assert(sizeof(FloorModel) == 416);

/// One word for files, one phrase for people.
std::string_view name(ImuUse use);
std::string_view describe(ImuUse use);

}  // namespace vdisp
