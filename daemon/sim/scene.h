// scene.h: the simulated world: ground, obstacles, and the camera's way through them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "config/config.h"
#include "daemon/geometry/frames.h"
#include "daemon/sim/chance.h"
#include "daemon/sim/ground.h"
#include "daemon/sim/simulator.h"
#include "ipc/records.h"

namespace vdisp::sim {

enum class Surface { gravel, planks, bricks, stone, bark };
inline constexpr int surface_count = 5;

/// World frame: x right, y down, z ahead, origin on the ground below the camera at the start. Angles are positive to the left.
struct SceneObject {
  ObjectKind kind = ObjectKind::box;
  bool textured = true;
  double x = 0, z = 0;  ///< m, centre of the footprint
  double width = 0, depth = 0, height = 0, yaw = 0;
  double bottom = 0;  ///< m over the ground, of what hangs there; 0: it stands on the ground
  Surface surface = Surface::planks;
  double brightness = 110;  ///< grey level in full light
  double contrast = 1;      ///< of its texture
  double radius() const;    ///< of the circle round the footprint
};

/// Columns right, down, ahead of a frame, in the world: row-major, world = axes * local.
using Axes = std::array<double, 9>;
Point turned(const Axes& axes, const Point& local);
Point turned_back(const Axes& axes, const Point& world);

struct CameraPose {
  Point position;  ///< of the left camera, world
  Axes axes;       ///< of the left rectified camera
  Axes level;      ///< of its frame h, which is level with the ground below it
  double heading;  ///< of the view
  double way;      ///< heading of the rover
  Point foot;      ///< where the rover stands: the ground below the camera
  bool climbs;     ///< stands on the slope
};

class Ride;

class Scene {
 public:
  explicit Scene(const sim_section& parameters);
  Scene(Scene&&) noexcept;
  ~Scene();

  /// Those that move are the last ones.
  const std::vector<SceneObject>& objects() const { return objects_; }
  size_t first_moving() const { return first_moving_; }
  /// The robot's ride; null where the scene is no world.
  const Ride* ride() const { return ride_.get(); }
  /// Goes on to a world's next frame.
  void step(const Order& order);
  /// Towards the light, and how far above the ground the lamps hang (0: it is the sun).
  Point to_light() const { return to_light_; }
  double ceiling() const { return ceiling_; }
  double ground_brightness() const { return ground_brightness_; }
  CameraPose pose(uint64_t frame) const;
  const Ground& terrain() const { return ground_; }
  /// The place on the ground that carries the camera and the way the rover heads, in the odometry frame (REP-103).
  Odometry rover(uint64_t frame) const;
  /// Gravity as the body of rover and camera feels it: it stands on its ground, and pitches with the camera.
  Imu imu(uint64_t frame) const;
  /// World y of the ground.
  double ground(double x, double z) const { return -ground_.height(x, z); }
  /// What is at a place of the ground, in frame h of the pose.
  Place place(const CameraPose& pose, double x, double z) const;
  /// m along the camera's y axis from its optical axis, `depth` m ahead of it, down to the ground.
  double ground_below(const CameraPose& pose, double depth) const;

  /// Middle and half the side of the square that is worth drawing with care.
  double middle_x() const { return middle_x_; }
  double middle_z() const { return middle_z_; }
  double extent() const { return extent_; }

  /// Fills the scene as a pose sees it, and for each object its number in it (TruthView::unlisted: none), and the ground.
  void describe(const CameraPose& pose, TruthView& view, std::span<uint8_t> numbers) const;

 private:
  struct Station {
    double x, z, heading;
  };
  Station station(uint64_t frame) const;
  double pitch(uint64_t frame) const;
  Point footing(const Station& at) const;
  Station along(double length) const;
  double clearance(double x, double z) const;
  void lay_path();
  void build_yard(Chance& chance);
  void build_flat(Chance& chance);
  void build_blank(Chance& chance);
  void build_five();
  void build_crowd(Chance& chance);
  void build_overhangs(Chance& chance);
  void enter_world();
  bool fits(const SceneObject& object, double path_gap, double gap) const;
  bool hides(const SceneObject& object) const;
  GroundPlane plane(const CameraPose& pose, double rise) const;
  void describe_ground(const CameraPose& pose, TruthScene& scene) const;

  sim_section parameters_;
  Ground ground_;
  double middle_x_ = 0, middle_z_ = 6, extent_ = 12;
  bool drives_ = false;
  Point to_light_{-0.52, -0.70, -0.49};
  double ceiling_ = 0, ground_brightness_ = 112;
  std::vector<SceneObject> objects_;
  size_t first_moving_ = SIZE_MAX;
  std::unique_ptr<Ride> ride_;
  std::vector<Station> path_;  ///< a closed way, a station every path_step_
  double path_step_ = 0;
};

}  // namespace vdisp::sim
