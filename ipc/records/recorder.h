// recorder.h: what is being recorded, what the flight recorder holds, and the calibration as a text.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "record.h"

namespace vdisp {

/// What made the flight recorder write.
enum class FlightCause : uint32_t { none = 0, asked, signal, floor_lost, camera_lost, bump, count };

/// `recorder`: as it was at the end of the step before. Counts are since the start of the daemon.
struct RecorderStatus {
  static constexpr RecordType type = RecordType::recorder;
  static constexpr uint16_t version = 1;
  RecordHeader header;
  uint32_t recording;   ///< 1: vdispd --record writes every step
  uint32_t flight;      ///< 1: there is a flight recorder ([recorder] seconds)
  uint64_t recorded;    ///< steps given to --record
  uint64_t held, room;  ///< steps in the flight recorder, and how many it can hold
  double held_s;        ///< from the oldest of them to the newest
  uint64_t lost;        ///< steps it could not keep while older ones were being written
  uint32_t writing;     ///< 1: a folder is being written
  FlightCause cause;    ///< of the last folder, or of the one being written
  uint64_t asked;       ///< times it was begun to write
  uint64_t written;     ///< folders that are complete
  uint64_t failed;      ///< folders that could not be written, or not to their end: `text` says why
  char text[512];       ///< the last folder, or why there is none
};

/// `calibration`: of the cameras as they are, the text that vdisp-calibrate writes as OpenCV YAML.
struct CalibrationText {
  static constexpr RecordType type = RecordType::calibration_text;
  static constexpr uint16_t version = 1;
  RecordHeader header;
  uint64_t hash;  ///< as in the headers of images
  uint32_t size;  ///< bytes of the text
  uint32_t unused;
  char text[8168];
};

static_assert(sizeof(RecorderStatus) == 600 && sizeof(CalibrationText) == 8192);

/// One word for files, one phrase for people.
std::string_view name(FlightCause cause);
std::string_view describe(FlightCause cause);

}  // namespace vdisp
