// record.h: what all records have in common: a header that says what they are, and an image around them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../image.h"

namespace vdisp {

enum class RecordType : uint16_t {
  none = 0,
  floor_model = 1,
  catalogue = 2,
  heartbeat = 3,
  truth_scene = 4,
  odometry = 5,
  imu = 6,
  drive = 7,
  event = 8,
  map_changes = 9,
  memory = 10,
  tracks = 11,
  camera_status = 12,
  snow_scores = 13,
  decision = 14,
  drive_command = 15,
  cross_check = 16,
  calibration_watch = 17,
  health = 18,
  recorder = 20,
  calibration_text = 21,
};

/// First member of each record: what it is, so that a reader can refuse what it does not know.
struct RecordHeader {
  RecordType type;
  uint16_t version;
  uint32_t bytes;
};

/// The spec of an image that carries record R.
template <class R>
constexpr ImageSpec record_spec() {
  return {Pixel::record, static_cast<uint16_t>(R::type), static_cast<uint16_t>(sizeof(R)), 1};
}

/// The record in an image made with record_spec<R>(); clears it and fills its header.
template <class R>
R& make_record(Image& image) {
  R* record = image.row<R>(0);
  *record = R{};
  record->header = {R::type, R::version, static_cast<uint32_t>(sizeof(R))};
  return *record;
}

/// The record in an image, or null where the image holds something else.
template <class R>
const R* record_of(const Image& image) {
  if (image.spec != record_spec<R>()) return nullptr;
  const R* record = image.row<R>(0);
  return record->header.type == R::type && record->header.version == R::version ? record : nullptr;
}

}  // namespace vdisp
