// memory.h: what is remembered from frame to frame: the pose it is put together by, and tracks.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "record.h"

namespace vdisp {

enum class MemoryState : uint32_t { frame_only = 0, fused = 1 };
/// Why nothing is remembered, or why what was remembered was forgotten last.
enum class MemoryCause : uint32_t {
  none = 0,
  no_odometry,   ///< none for [control] maxAge, or ever, or no numbers
  late,          ///< the newest is older than [Memory] maxLag when the frame was taken
  jump,          ///< it moved faster than [control] maxSpeed or maxTurn
  anew,          ///< it began anew elsewhere (Odometry::frame)
  backwards,     ///< its time or the frames' ran backwards
  contradicted,  ///< all that is tracked moves as one: the odometry does not tell how the rover moves
  pause,         ///< there was none for more than a second
  count          ///< number of causes, not one of them
};

/// What `fused` and `tracks` of the same frame are made of, topic `memory`: the rover's pose in the odometry frame when the frame was
/// taken.
struct Memory {
  static constexpr RecordType type = RecordType::memory;
  static constexpr uint16_t version = 1;
  RecordHeader header;
  MemoryState state;
  MemoryCause cause;   ///< frame_only: why; fused: why it was forgotten last
  uint32_t forgotten;  ///< how often all was forgotten: with another number odometry coordinates of before mean nothing
  uint32_t unused;
  double x, y, yaw;  ///< m, m, rad; NaN: not known
  double lag_s;      ///< from the newest odometry to the frame: carried on over that time; NaN: none
  double since_s;    ///< how long it has been remembered since; 0 for frame_only
};

/// One obstacle that was followed from frame to frame.
struct Track {
  static constexpr uint32_t moving = 1, seen = 2, cut = 4;  ///< flags; seen: in this frame; cut: by the border of the view
  uint32_t id;                                              ///< never used again in an epoch
  uint32_t flags;
  float x, y;                    ///< m, middle of what is seen of it
  float speed_x, speed_y;        ///< m/s over the ground; where Tracks::frame is 0, against the rover
  float speed_deviation;         ///< m/s, standard deviation of each
  float size_x, size_y, height;  ///< m, along the axes of the frame, of what is seen; over the floor
  float age_s, unseen_s;         ///< since first seen; since last seen
};

/// Topic `tracks`: obstacles with position, size, age and velocity, oldest first.
struct Tracks {
  static constexpr RecordType type = RecordType::tracks;
  static constexpr uint16_t version = 1;
  static constexpr uint32_t capacity = 64;
  RecordHeader header;
  uint32_t frame;  ///< grid_of_odometry: x, y of the odometry frame; 0: of the rover frame r, as no odometry tells where it is
  uint32_t count;
  Track tracks[capacity];
};

static_assert(sizeof(Memory) == 64 && sizeof(Track) == 48 && sizeof(Tracks) == 16 + 48 * Tracks::capacity);
std::string_view name(MemoryState state);
std::string_view name(MemoryCause cause);
std::string_view describe(MemoryCause cause);

}  // namespace vdisp
