// calibration_watch.h: whether the calibration still holds, by the rows of good matches while the daemon runs.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "record.h"

namespace vdisp {

enum class CalibrationState : uint32_t {
  measuring = 0,  ///< too few points yet
  good,
  drifted,  ///< rows differ by more than `limit_px`
  count
};

/// `row_error`: how far rows of the rectified views differ, by points of the last seconds. NaN while measuring.
struct CalibrationWatch {
  static constexpr RecordType type = RecordType::calibration_watch;
  static constexpr uint16_t version = 1;
  RecordHeader header;
  CalibrationState state;
  uint32_t points;                ///< in the window
  double window_s;                ///< age of the oldest of them
  double median_px, p90_px;       ///< of |rows|
  double shift_px;                ///< of the right view downwards, in the middle of the image: cameras nod against each other
  double shift_deviation_px;      ///< how well that is known (standard deviation)
  double rotation_rad;            ///< of the right camera about its view, against the calibration: rows fall to the right by so much
  double rotation_deviation_rad;  ///< likewise
  double limit_px;                ///< [image source] rowLimit
  uint64_t drifts;                ///< how often it has drifted since the start or the event `recording`
};

static_assert(sizeof(CalibrationWatch) == 88);

/// One word for files.
std::string_view name(CalibrationState state);

}  // namespace vdisp
