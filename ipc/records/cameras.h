// cameras.h: what the cameras deliver and what becomes of it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "record.h"

namespace vdisp {

/// One camera of the pair. Counts are since the start of the daemon.
struct CameraView {
  uint32_t open;        ///< 1: it delivers, or ought to
  uint32_t opened;      ///< how often
  uint64_t frames;      ///< whole ones
  uint64_t incomplete;  ///< parts were missing, or damaged: never processed
  uint64_t unpaired;    ///< had no other half
  uint64_t refused;     ///< not newer than the frame before
  double exposure_us;   ///< as last set; NaN: left to the camera
  double gain_db;       ///< likewise
  double floor_level;   ///< 0..255, mean of the lower half of its view
  double dark, bright;  ///< shares of its pixels below 8 and above 247
};

/// `camera/status`: what the cameras deliver and what becomes of it.
struct CameraStatus {
  static constexpr RecordType type = RecordType::camera_status;
  static constexpr uint16_t version = 1;
  RecordHeader header;
  uint64_t pairs;      ///< that were complete
  uint64_t skipped;    ///< of those: given up for a newer one before the tree was ready
  double apart_ms;     ///< right after left, of the last pair; where there is none, of the frames nearest to each other
  double age_ms;       ///< from the middle of the exposure to the start of this step
  uint32_t exchanged;  ///< 1: the first view of a frame was found, or is said, to be the right one
  uint32_t cameras;    ///< 1: one that gives both views; 2
  CameraView view[2];
};

static_assert(sizeof(CameraView) == 80 && sizeof(CameraStatus) == 208);

}  // namespace vdisp
