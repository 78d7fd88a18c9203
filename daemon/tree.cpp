// tree.cpp: THE picture: two raw images to the map (paper figure 6). The order of add() is the schedule.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/tree.h"

#include "daemon/control/republish.h"
#include "daemon/sources/calibration_report.h"
#include "daemon/sources/camera_report.h"
#include "daemon/stages/calibration_watch.h"
#include "daemon/stages/census_disparity.h"
#include "daemon/stages/census_view.h"
#include "daemon/stages/classify.h"
#include "daemon/stages/cross_check.h"
#include "daemon/stages/decide.h"
#include "daemon/stages/depth_map.h"
#include "daemon/stages/disparity.h"
#include "daemon/stages/drive.h"
#include "daemon/stages/features.h"
#include "daemon/stages/floor.h"
#include "daemon/stages/fused_map.h"
#include "daemon/stages/height.h"
#include "daemon/stages/limit.h"
#include "daemon/stages/map.h"
#include "daemon/stages/map_changes.h"
#include "daemon/stages/occupancy.h"
#include "daemon/stages/odometry_check.h"
#include "daemon/stages/plane_floor.h"
#include "daemon/stages/rectify.h"
#include "daemon/stages/segments.h"
#include "daemon/stages/show_line.h"
#include "daemon/stages/show_obstacle.h"
#include "daemon/stages/show_scene.h"
#include "daemon/stages/smoothed_view.h"
#include "daemon/stages/surfaces.h"
#include "daemon/stages/tracks.h"
#include "daemon/stages/vdisparity.h"

namespace vdisp {
namespace {

using std::make_unique;
using Handles = std::vector<Handle>;

/// What all branches need.
struct Trunk {
  Driver& driver;
  Machine& machine;
  const Config& config;
  Handle left, right;  // rectified
  Handles in;          // odometry, imu, drive, event
};

/// The first paper as it is: the floor is a line in the v-disparity. Gives the map.
Handles add_line_branch(const Trunk& t, Handle disparity) {
  const auto& [driver, machine, config, left, right, in] = t;
  const auto vdisparity = driver.add("vdisparity", make_unique<VDisparity>(machine, config), {disparity});
  const auto floor = driver.add_set({"floor", "floor_model"}, make_unique<Floor>(machine, config), {vdisparity}, Need::always);
  const auto limit = driver.add("limit", make_unique<Limit>(config), {floor[0], floor[1]});
  const auto map = driver.add("map", make_unique<Map>(machine, config), {disparity, limit, floor[1]}, Need::always);
  driver.set_result(map);

  // For the eye: run only while somebody looks, and after the map.
  driver.add("obstacles", make_unique<ShowObstacle>(machine), {disparity, limit});
  driver.add_set({"segments", "segment_obstacles"}, make_unique<Segments>(config), {disparity, even_blind(floor[1])});
  driver.add("height", make_unique<Height>(config), {disparity, floor[1]});
  driver.add("show_floor", make_unique<ShowLine>(std::array<uint8_t, 3>{255, 60, 60}), {vdisparity, floor[0]});
  driver.add("show_limit", make_unique<ShowLine>(std::array<uint8_t, 3>{80, 160, 255}), {vdisparity, limit});
  return {map};
}

/// The floor is a plane with a profile on it. Gives the map that remembers, with its reasons.
Handles add_plane_branch(const Trunk& t, Handle disparity) {
  const auto& [driver, machine, config, left, right, in] = t;
  const auto floor = driver.add_set({"floor", "floor_model"}, make_unique<PlaneFloor>(machine, config),
                                    {disparity, left, even_blind(in[1])}, Need::always);
  const auto over =
      driver.add_set({"height", "surface", "standing", "hanging"}, make_unique<Surfaces>(machine, config), {disparity, floor[1], left});
  const auto ground = driver.add_set({"occupancy", "reason"}, make_unique<Occupancy>(machine, config),
                                     {disparity, over[1], over[0], over[2], over[3], floor[1], left}, Need::always);
  driver.add("map_changes", make_unique<MapComparison>(), {ground[0]}, Need::always);
  driver.set_result(driver.add("map", make_unique<Map>(machine, config), {over[2], floor[1]}, Need::always));

  const auto memory = driver.add("memory", make_unique<OdometryCheck>(config),
                                 {ground[0], even_blind(in[0]), driver.last("tracks", record_spec<Tracks>())}, Need::always);
  driver.add("tracks", make_unique<ObstacleTracks>(config), {ground[0], ground[1], over[2], over[0], floor[1], memory}, Need::always);
  const auto fused = driver.add_set({"fused", "fused_reason"}, make_unique<FusedMap>(config),
                                    {ground[0], ground[1], disparity, floor[1], memory}, Need::always);
  driver.add("fused_changes", make_unique<MapComparison>(), {fused[0]}, Need::always);

  const auto limit = driver.add("limit", make_unique<Limit>(config), {floor[0], floor[1]});
  const auto vdisparity = driver.add("vdisparity", make_unique<VDisparity>(machine, config), {disparity});
  driver.add("obstacles", make_unique<ShowSurface>(), {over[1]});
  driver.add_set({"segments", "segment_obstacles"}, make_unique<Segments>(config), {disparity, even_blind(floor[1])});
  driver.add("show_scene", make_unique<ShowScene>(config), {left, over[1], ground[0], floor[1]});
  driver.add("show_floor", make_unique<ShowLine>(std::array<uint8_t, 3>{255, 60, 60}), {vdisparity, floor[0]});
  driver.add("show_limit", make_unique<ShowLine>(std::array<uint8_t, 3>{80, 160, 255}), {vdisparity, limit});
  return fused;
}

/// The second paper: census images, depth map, classifiers. Gives their scores.
Handle add_snow_branch(const Trunk& t) {
  const auto& [driver, machine, config, left, right, in] = t;
  const auto smooth_left = driver.add("smooth/left", make_unique<SmoothedView>(machine, config), {left});
  const auto smooth_right = driver.add("smooth/right", make_unique<SmoothedView>(machine, config), {right});
  const auto census_left = driver.add("census/left", make_unique<CensusView>(machine), {smooth_left});
  const auto census_right = driver.add("census/right", make_unique<CensusView>(machine), {smooth_right});
  const auto disparity =
      driver.add("census_disparity", make_unique<CensusDisparity>(machine, config), {census_left, census_right, smooth_left});
  const auto depth_map = driver.add("depth_map", make_unique<DepthMap>(machine, config), {disparity});
  const auto features = driver.add("features", make_unique<Features>(config), {disparity, depth_map});
  return driver.add("snow", make_unique<Classify>(config), {features, smooth_left}, Need::always);
}

/// What the rover is to do, of all that the detectors say of the way.
void add_drive(const Trunk& t, const Handles& ways) {
  const bool both = t.config.detects("vdisparity") && t.config.detects("snow");
  Handles seen = ways;
  if (both)
    for (size_t i = 0; i + 1 < seen.size(); ++i) seen[i] = even_blind(seen[i]);  // of the map; the classifiers' scores are the last
  const auto decision = t.driver.add("decision", make_unique<Decide>(t.config), seen, Need::always);
  Handles orders{even_blind(decision), even_blind(t.in[2])};
  if (both) orders.push_back(even_blind(t.driver.add("cross_check", make_unique<CompareWays>(t.config), ways, Need::always)));
  t.driver.add("drive", make_unique<Drive>(t.config), orders, Need::always);
}

}  // namespace

void build_tree(Driver& driver, std::unique_ptr<StereoSource> source, Machine& machine, const Config& config, Inputs& inputs) {
  StereoSource& stereo = *source;
  const auto calibration = stereo.calibration();

  // A simulated robot moves as the tree said in the last frame.
  std::vector<Handle> orders;
  if (stereo.driven()) orders.push_back(driver.last("drive", record_spec<DriveCommand>()));
  const auto camera = driver.add_set({"camera/left", "camera/right"}, std::move(source), orders, Need::always);
  if (stereo.cameras()) driver.add("camera/status", make_unique<CameraReport>(stereo), {}, Need::always);
  if (calibration) driver.add("calibration", make_unique<CalibrationReport>(*calibration));
  const auto in = driver.add_set(
      {std::begin(input_topics), std::end(input_topics)},
      make_unique<Republish>(
          inputs, [&stereo] { return stereo.odometry(); }, [&stereo] { return stereo.imu(); }, [&stereo] { return stereo.recorded(); }),
      {}, Need::always);
  const auto left = driver.add("left", make_unique<Rectify>(Side::left, calibration, machine, config), {camera[0]});
  const auto right = driver.add("right", make_unique<Rectify>(Side::right, calibration, machine, config), {camera[1]});
  const Trunk trunk{driver, machine, config, left, right, in};

  // The floor of the last frame tells the matcher where to expect this one's.
  Handles views{left, right};
  const bool floors = config.detects("vdisparity"), snow = config.detects("snow");
  if (floors) views.push_back(driver.last("floor_model", record_spec<FloorModel>()));
  const Need matches = snow && !floors ? Need::on_demand : Need::always;  // census_disparity is all that snow needs
  const auto disparity = driver.add("disparity", make_unique<Disparity>(machine, config), views, matches);
  driver.set_result(disparity);
  driver.add("row_error", make_unique<CalibrationWatcher>(config), {left, right, disparity}, matches);

  Handles ways;
  if (floors) ways = config.floor.model == "line" ? add_line_branch(trunk, disparity) : add_plane_branch(trunk, disparity);
  if (snow) ways.push_back(add_snow_branch(trunk));
  if (snow && !floors) driver.set_result(ways.back());
  if (!ways.empty()) add_drive(trunk, ways);
  stereo.add_truth(driver, camera[0]);
}

}  // namespace vdisp
