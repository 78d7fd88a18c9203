// truth.h: what the simulator knows: obstacles, drop-offs, cells.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "record.h"

namespace vdisp {

enum class ObjectKind : uint32_t { box = 1, post, wall, rock, beam };

/// One obstacle of the simulator, in the camera's true horizontal frame h at the moment of exposure.
struct TruthObject {
  ObjectKind kind;
  uint32_t textured;   ///< 1: enough texture to be matched
  float x, z;          ///< m, centre of the footprint
  float width, depth;  ///< m, along its own axes
  float height;        ///< m above the ground at its place
  float yaw;           ///< rad about the vertical
  float base;          ///< m, of the ground at its place over the ground below the camera
  float bottom;        ///< m above the ground at its place, of what hangs over it; 0: it stands on the ground
};

/// Where the ground falls away before the rover, in the same frame.
struct TruthDrop {
  float depth;             ///< m; 0: nowhere
  float across;            ///< m from the near edge to the far one; 0: it has none
  float left_x, left_z;    ///< m, left end of the near edge, at most 20 m aside
  float right_x, right_z;  ///< m, its right end
};

/// What a cell of the map truly is, the values of `truth/map_cells`. The first that holds of: an obstacle higher than max_height stands
/// or hangs lower than 1 m over a part of it; an edge goes through it; its ground is outside the picture; less than a fifth of its
/// ground is seen, or all of it takes less than a quarter of a row; something hangs over it at 1 m or more; it is the bottom of a
/// drop-off.
enum class TruthCell : uint8_t { outside = 0, free = 1, obstacle = 2, drop_off = 3, overhang = 4, hidden = 5, below = 6 };

/// The simulator's truth for one frame, topic `truth/scene`. Objects are numbered from 1 as in `truth/object`.
struct TruthScene {
  static constexpr RecordType type = RecordType::truth_scene;
  static constexpr uint16_t version = 2;
  static constexpr uint32_t capacity = 32;
  RecordHeader header;
  double pitch_rad, roll_rad, height_m;  ///< of the camera over the ground below it
  double slope_rad;                      ///< of the ground ahead, positive: rising
  uint32_t count;
  uint32_t unused;
  TruthObject objects[capacity];
  double x_m, y_m, yaw_rad;  ///< of the rover in the world (REP-103: x ahead, y left of its start, yaw to the left)
  double foot_m;             ///< m ahead where the slope begins; 0: there is none ahead
  double crest_m;            ///< m ahead where the ground begins to fall away as a slope; 0: nowhere
  TruthDrop drop;
};

std::string_view name(TruthCell cell);

}  // namespace vdisp
