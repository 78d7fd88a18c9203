// simulator.h: what the source and the tests need of the simulator; the renderer behind it is loaded when it is asked for.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "config/config.h"
#include "daemon/geometry/calibration.h"
#include "ipc/records.h"

namespace vdisp::sim {

/// A plane of the ground as one pose sees it: pitch and roll of the camera against it, distance of the camera from it.
struct GroundPlane {
  double pitch, roll, height;
};

/// What the left rectified camera would see of one frame, exactly. Rows are `width` long.
struct TruthView {
  static constexpr uint8_t ground = 0, unlisted = 254, sky = 255;
  int width = 0, height = 0;
  std::span<const float> depth;      ///< m along the view; 0: sky
  std::span<const float> elevation;  ///< m above the ground at its place
  std::span<const uint8_t> object;   ///< number in `scene` from 1; ground, sky, or unlisted: an object beyond its range or capacity
  TruthScene scene{};
  std::array<GroundPlane, 2> planes{};  ///< below the start, and the slope
  int plane_count = 1;                  ///< 1 where the ground is flat, 0 where it is no planes
  bool rising = false;                  ///< the slope rises: the ground is the higher of both planes, else the lower
};

/// What hangs at least so high, m, is not in the way of any rover; the scenes have nothing at heights about this.
inline constexpr double overhang_clearance = 1;

/// What is at one place of the ground.
struct Place {
  double down;      ///< m, the ground there below the camera, in frame h
  double drop;      ///< m that it lies lower than it did before it fell away
  double obstacle;  ///< m over the ground, top of the tallest that stands or hangs in the way; 0: nothing does
  double overhang;  ///< m over the ground, bottom of the lowest that hangs higher than overhang_clearance; 0: nothing does
};

/// Whether a scene of this name is a world: closed, with a robot in it.
inline bool is_world(const std::string& scene) { return scene == "office" || scene == "garage" || scene == "rocks"; }

/// What the robot in a world is told for the time to the next frame.
struct Order {
  bool brake = true;  ///< whatever the rest says
  double speed = 0, turn_rate = 0;
};

/// How the robot in a world fares, and what an expert would do in its place. Lengths in m, times in s; odometry frame (REP-103).
struct RobotReport {
  double x, y, yaw;  ///< of its middle
  double speed, turn_rate;
  double clearance;      ///< between it and the nearest thing, at most 5
  double travelled;      ///< since the start
  bool collided, stuck;  ///< in the time to this frame; then it is put where there is room, and waits for that if people stand there
  uint64_t collisions, stuck_times;
  const char* met;    ///< what it ran into last; null: nothing yet
  Steering steering;  ///< the expert's label, as in Decision
  double clearness, since_s;
  uint64_t changes;
};

/// What stands in a world as seen from above, corners one after the other, odometry frame.
struct WorldOutline {
  const char* what;
  std::vector<std::array<double, 2>> corners;
};

/// Everything depends on the parameters and the frame's number only: the same frame has the same bytes. In a world it depends on the
/// orders too: frames come one after the other there, and render() and truth() show the one that step() last went to.
class Simulator {
 public:
  virtual ~Simulator() = default;
  Simulator() = default;
  Simulator(const Simulator&) = delete;
  Simulator& operator=(const Simulator&) = delete;

  /// The cameras as they are, and the rectified pair.
  virtual const Calibration& calibration() const = 0;
  /// Draws both raw views. One call at a time; beside a call of truth().
  virtual void render(uint64_t frame, std::byte* left, std::byte* right, size_t stride) noexcept = 0;
  /// Valid until the next call, which is cheap for the same frame. One call at a time.
  virtual const TruthView& truth(uint64_t frame) noexcept = 0;
  /// What is x m to the right and z m ahead in frame h of the frame that truth() was asked for last.
  virtual Place place(double x, double z) const noexcept = 0;
  /// Row of the ground `depth` m along the view in the column through the optical centre, of the same frame; it may lie outside.
  virtual double ground_row(double depth) const noexcept = 0;
  /// Where the rover is, with the ground below its camera as its origin: x, y, z, roll, pitch, yaw of the record. At any time.
  virtual Odometry rover(uint64_t frame) const noexcept = 0;
  /// What an accelerometer on the rover measures, camera and rover being one body: acceleration and attitude of the record. At any time.
  virtual Imu imu(uint64_t frame) const noexcept = 0;
  /// Null where the scene is no world.
  virtual const RobotReport* robot() const noexcept { return nullptr; }
  /// Goes on to the next frame of a world. Not beside a call of anything else.
  virtual void step(const Order&) noexcept {}
  /// What does not move in a world.
  virtual std::vector<WorldOutline> outlines() const { return {}; }
};

/// From frame to frame, ns; without a rate 1/30 s.
inline int64_t frame_period_ns(const sim_section& parameters) {
  return static_cast<int64_t>(1e9 / (parameters.rate > 0 ? parameters.rate : 30.0) + 0.5);
}

/// The module's one symbol, `vdisp_make_simulator`. Null: no memory or no renderer.
using MakeSimulator = Simulator*(const sim_section& parameters);
inline constexpr const char* make_simulator_symbol = "vdisp_make_simulator";

}  // namespace vdisp::sim
