// sim_ground_test.cpp: the simulator's ground, what hangs over it and gapes in it, and what befalls the camera, against arithmetic.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

#include "daemon/sim/ground.h"
#include "daemon/sim/renderer.h"
#include "daemon/sim/scene.h"
#include "daemon/sources/sim.h"

namespace vdisp {
namespace {

constexpr double degree = M_PI / 180;

sim_section small(const std::string& scene, const std::string& ground = "slope") {
  sim_section parameters;
  parameters.scene = scene;
  parameters.ground = ground;
  parameters.width = 320;
  parameters.height = 240;
  return parameters;
}

/// A pixel of the truth in the world, by the pose.
Point world_of(const sim::CameraPose& pose, const StereoView& view, const sim::TruthView& truth, int u, int v) {
  const Point seen = view.point(u, v, view.disparity(truth.depth[static_cast<size_t>(v) * truth.width + u]));
  const Point p = sim::turned(pose.axes, seen);
  return {p.x + pose.position.x, p.y + pose.position.y, p.z + pose.position.z};
}

TEST(SimGround, profiles_rise_and_fall_where_they_say) {
  for (int seed = 0; seed < 50; ++seed) {
    sim_section parameters = small("empty", "ramp");
    parameters.seed = seed;
    parameters.slope = 12 * degree;
    const sim::Ground ramp(parameters);
    EXPECT_GE(ramp.foot(), 1.5);
    EXPECT_LE(ramp.foot(), 3);
    EXPECT_EQ(ramp.height(0.3, ramp.foot() - 0.01), 0);
    EXPECT_NEAR(ramp.height(-1, ramp.foot() + 2), 2 * std::tan(12 * degree), 1e-9);
    EXPECT_EQ(ramp.crest(), 0);
    parameters.slope = -parameters.slope;
    const sim::Ground fall(parameters);
    EXPECT_EQ(fall.crest(), fall.foot());
    EXPECT_NEAR(fall.height(0, fall.foot() + 1), -std::tan(12 * degree), 1e-9);
    parameters.slope = 10 * degree;
    parameters.ground = "crest";
    const sim::Ground crest(parameters);
    EXPECT_GE(crest.crest(), 2);
    EXPECT_LE(crest.crest(), 3.5);
    const double top = crest.height(0, crest.crest());
    EXPECT_NEAR(top, std::tan(10 * degree) * (crest.crest() - 1), 1e-9);
    EXPECT_NEAR(crest.height(0, crest.crest() + 1), top - std::tan(10 * degree), 1e-9);
  }
}

TEST(SimGround, drop_offs_are_deep_enough_and_across_the_way) {
  std::map<std::string, int> whole;
  for (const char* shape : {"kerb", "ditch"}) {
    for (int seed = 0; seed < 50; ++seed) {
      sim_section parameters = small("flat", shape);
      parameters.seed = seed;
      const sim::Ground ground(parameters);
      const sim::Hollow& h = ground.hollow();
      const double edge = h.near / std::cos(h.turn);  // straight ahead
      EXPECT_GE(h.depth, 0.3);
      EXPECT_LE(h.depth, 1.0);
      EXPECT_GE(edge, 1.1);
      EXPECT_LE(edge, 3.1);
      EXPECT_EQ(ground.height(0, edge - 0.02), 0);
      EXPECT_NEAR(ground.height(0, edge + 0.02), -h.depth, 1e-9);
      EXPECT_NEAR(ground.drop(0, edge + 0.02), h.depth, 1e-9);
      // 4 m behind the edge, at a right angle to it.
      const double x = -4 * std::sin(h.turn), z = edge + 4 * std::cos(h.turn);
      EXPECT_NEAR(ground.height(x, z), std::string(shape) == "kerb" ? -h.depth : 0, 1e-9);
      whole[shape] += h.left < -5 && h.right > 5;
      const sim::Scene scene(parameters);
      for (const sim::SceneObject& o : scene.objects()) EXPECT_TRUE(ground.whole(o.x, o.z, o.radius()));
    }
    EXPECT_GT(whole[shape], 5) << shape;
    EXPECT_LT(whole[shape], 45) << shape;
  }
}

TEST(SimGround, bumps_have_the_roughness_asked_for_and_none_under_the_rover) {
  sim_section parameters = small("empty");
  parameters.roughness = 0.05;
  const sim::Ground ground(parameters);
  double least = 0, most = 0, steepest = 0;
  for (double x = -3; x < 3; x += 0.02) {
    for (double z = 1; z < 6; z += 0.02) {
      least = std::min(least, ground.height(x, z));
      most = std::max(most, ground.height(x, z));
      steepest = std::max(steepest, std::abs(ground.height(x, z + 0.01) - ground.height(x, z)) / 0.01);
    }
  }
  EXPECT_NEAR(least, -0.05, 0.006);
  EXPECT_NEAR(most, 0.05, 0.006);
  EXPECT_LT(steepest, 0.5);
  EXPECT_GT(steepest, 0.1);
  EXPECT_EQ(ground.height(0.1, 0.2), 0);
}

TEST(SimGround, what_is_seen_lies_on_the_ground_and_the_truth_tells_its_height) {
  struct Case {
    const char *scene, *ground;
    double slope, roughness, roll;
  };
  for (const Case& c : {Case{"flat", "ramp", 0.25, 0, 0}, Case{"flat", "ramp", -0.2, 0, 0.17}, Case{"flat", "crest", 0.17, 0, -0.17},
                        Case{"flat", "slope", 0, 0.05, 0}, Case{"flat", "kerb", 0, 0, 0.1}, Case{"flat", "ditch", 0.1, 0.02, 0},
                        Case{"crowded", "slope", 0, 0, 0.17}, Case{"overhangs", "slope", 0, 0, 0}, Case{"drive", "slope", 0, 0.05, 0}}) {
    sim_section parameters = small(c.scene, c.ground);
    parameters.slope = c.slope;
    parameters.roughness = c.roughness;
    parameters.roll = c.roll;
    const auto simulator = sim::make_simulator(parameters);
    const sim::Scene scene(parameters);
    const sim::TruthView& truth = simulator->truth(40);
    const sim::CameraPose pose = scene.pose(40);
    const StereoView& view = simulator->calibration().view;
    int ground = 0, objects = 0;
    for (int v = 0; v < truth.height; ++v) {
      for (int u = 0; u < truth.width; ++u) {
        const size_t pixel = static_cast<size_t>(v) * truth.width + u;
        if (truth.depth[pixel] <= 0 || truth.depth[pixel] > 8) continue;
        const Point p = world_of(pose, view, truth, u, v);
        const double over = -p.y - scene.terrain().height(p.x, p.z);
        if (truth.object[pixel] == sim::TruthView::ground) {
          ++ground;
          // On the wall of a hollow height is no measure of place.
          if (scene.terrain().whole(p.x, p.z, 0.01) || scene.terrain().drop(p.x, p.z) > scene.terrain().hollow().depth - 1e-6) {
            ASSERT_NEAR(over, 0, 0.006) << c.scene << " " << c.ground << " " << p.x << " " << p.z;
          }
        } else {
          ++objects;
          ASSERT_NEAR(over, truth.elevation[pixel], 0.004) << c.scene << " " << c.ground;
        }
      }
    }
    EXPECT_GT(ground, 3000) << c.scene << " " << c.ground;
    EXPECT_GT(objects, 500) << c.scene << " " << c.ground;
    EXPECT_NEAR(truth.scene.roll_rad, c.roll, 1e-9);
    EXPECT_NEAR(truth.scene.pitch_rad, parameters.pitch, 1e-9);
    EXPECT_NEAR(truth.scene.height_m, parameters.cameraHeight, 1e-9);
  }
}

TEST(SimGround, pitching_follows_the_sine_and_returns) {
  sim_section parameters = small("empty");
  parameters.rate = 30;
  parameters.pitching = 5 * degree;
  parameters.pitchingRate = 2;
  const auto simulator = sim::make_simulator(parameters);
  for (uint64_t frame : {0u, 1u, 4u, 11u, 15u})
    EXPECT_NEAR(simulator->truth(frame).scene.pitch_rad,
                parameters.pitch + 5 * degree * std::sin(2 * M_PI * 2 * static_cast<double>(frame) / 30), 1e-6)
        << frame;
}

/// Share of the pixels that show floor without obstacles and are of an obstacle here.
double covered(const sim_section& parameters) {
  sim_section bare = parameters;
  bare.scene = "empty";
  const auto with = sim::make_simulator(parameters), without = sim::make_simulator(bare);
  const sim::TruthView &a = with->truth(0), &b = without->truth(0);
  double floor = 0, hidden = 0;
  for (size_t i = 0; i < a.depth.size(); ++i) {
    if (b.depth[i] <= 0 || b.depth[i] > 5.5f) continue;
    ++floor;
    hidden += a.object[i] != sim::TruthView::ground;
  }
  return hidden / floor;
}

TEST(SimGround, a_crowd_covers_seventy_percent_of_the_floor) {
  double sum = 0;
  for (int seed = 0; seed < 50; ++seed) {
    sim_section parameters = small("crowded");
    parameters.width = 160;
    parameters.height = 120;
    parameters.seed = seed;
    const double share = covered(parameters);
    EXPECT_GT(share, 0.6) << seed;
    EXPECT_LT(share, 0.8) << seed;
    sum += share;
  }
  EXPECT_NEAR(sum / 50, 0.7, 0.04);
}

TEST(SimGround, beams_hang_high_or_low_and_leave_the_ground_free) {
  int high = 0, low = 0;
  for (int seed = 0; seed < 50; ++seed) {
    sim_section parameters = small("overhangs");
    parameters.seed = seed;
    const sim::Scene scene(parameters);
    const sim::CameraPose pose = scene.pose(0);
    for (const sim::SceneObject& o : scene.objects()) {
      if (o.kind != ObjectKind::beam) continue;
      high += o.bottom >= 1.2;
      low += o.bottom <= 0.7;
      EXPECT_TRUE((o.bottom >= 1.2 && o.bottom <= 1.6) || (o.bottom >= 0.3 && o.bottom <= 0.7));
      EXPECT_GT(o.height, o.bottom + 0.09);
      const Point middle = sim::turned_back(pose.level, {o.x - pose.position.x, -pose.position.y, o.z - pose.position.z});
      const sim::Place place = scene.place(pose, middle.x, middle.z);
      EXPECT_EQ(place.overhang, o.bottom >= 1 ? o.bottom : 0);
      EXPECT_EQ(place.obstacle, o.bottom >= 1 ? 0 : o.height);
    }
  }
  EXPECT_GT(high, 45);
  EXPECT_GT(low, 12);
}

TEST(SimGround, the_rover_goes_where_the_truth_says) {
  sim_section parameters = small("drive");
  parameters.rate = 10;
  const sim::Scene scene(parameters);
  TruthScene before{};
  for (uint64_t frame = 0; frame <= 40; ++frame) {
    sim::TruthView view;
    std::vector<uint8_t> numbers(scene.objects().size());
    scene.describe(scene.pose(frame), view, numbers);
    const TruthScene& now = view.scene;
    if (frame == 0) {
      EXPECT_NEAR(now.x_m, 0, 1e-9);
      EXPECT_NEAR(now.y_m, 0, 1e-9);
      EXPECT_NEAR(now.yaw_rad, 0, 1e-3);
    } else {
      // 0.5 m/s, along its own nose.
      EXPECT_NEAR(std::hypot(now.x_m - before.x_m, now.y_m - before.y_m), 0.05, 0.002);  // the way is laid out to 3 mm
      EXPECT_NEAR(std::atan2(now.y_m - before.y_m, now.x_m - before.x_m), (now.yaw_rad + before.yaw_rad) / 2, 0.01);
      // What stands still is where it was: seen from the moved rover by its pose.
      for (uint32_t i = 0, j = 0; i < now.count && j < before.count; ++i, ++j) {
        if (now.objects[i].width != before.objects[j].width) break;  // another one came into the list
        const auto place = [](const TruthScene& s, const TruthObject& o) {
          const double forward = o.z, left = -o.x;
          return std::array{s.x_m + forward * std::cos(s.yaw_rad) - left * std::sin(s.yaw_rad),
                            s.y_m + forward * std::sin(s.yaw_rad) + left * std::cos(s.yaw_rad)};
        };
        // Frame h begins at the camera, which stands over the rover's origin.
        EXPECT_NEAR(place(now, now.objects[i])[0], place(before, before.objects[j])[0], 1e-5);
        EXPECT_NEAR(place(now, now.objects[i])[1], place(before, before.objects[j])[1], 1e-5);
      }
    }
    before = now;
  }
  EXPECT_GT(before.count, 3u);
}

TEST(SimGround, events_begin_with_their_frame) {
  for (const char* event : {"cap", "dark", "bright", "blank"}) {
    sim_section parameters = small("flat");
    parameters.event = event;
    parameters.eventFrame = 3;
    const auto simulator = sim::make_simulator(parameters);
    const auto look = [&](uint64_t frame) {
      std::vector<uint8_t> left(size_t{320} * 240), right(left);
      simulator->render(frame, reinterpret_cast<std::byte*>(left.data()), reinterpret_cast<std::byte*>(right.data()), 320);
      const double mean = std::accumulate(left.begin(), left.end(), 0.0) / static_cast<double>(left.size());
      double squares = 0;
      for (uint8_t value : left) squares += (value - mean) * (value - mean);
      return std::array{mean, std::sqrt(squares / static_cast<double>(left.size()))};
    };
    const auto before = look(2), after = look(3);
    EXPECT_GT(before[1], 15) << event;
    EXPECT_LT(after[1], 4) << event;
    const std::map<std::string, std::pair<double, double>> mean{
        {"cap", {0, 2}}, {"dark", {0, 6}}, {"bright", {253, 255}}, {"blank", {149, 151}}};
    EXPECT_GE(after[0], mean.at(event).first) << event;
    EXPECT_LE(after[0], mean.at(event).second) << event;
  }
}

/// One step of the source in a tree; the truth stages by topic.
class Truth {
 public:
  explicit Truth(const Config& config) : driver_(1) {
    auto source = open_sim(config);
    StereoSource* stereo = source.get();
    const auto cameras = driver_.add_set({"camera/left", "camera/right"}, std::move(source), {}, Need::always);
    stereo->add_truth(driver_, cameras[0]);
    driver_.connect([](const std::string&, const ImageSpec& spec) { return std::make_unique<BufferOutlet>(spec); });
    driver_.need_all();
    driver_.set_viewer([this](const Topic& topic, const Image& image) { images_[topic.name] = &image; });
    EXPECT_EQ(driver_.step(), Outcome::valid);
  }
  const Image& operator[](const std::string& topic) { return *images_.at(topic); }

 private:
  Driver driver_;
  std::map<std::string, const Image*> images_;
};

/// Cells of the kind in a row of the map, in the columns that the camera sees.
TruthCell cell(const Image& cells, double x, double z) {
  return static_cast<TruthCell>(cells.row<uint8_t>(49 - static_cast<int>(z * 10))[static_cast<int>(x * 10 + 25.5)]);
}

TEST(SimGround, cells_of_a_kerb_are_free_then_edge_then_hidden_then_below) {
  Config config;
  config.sim = small("empty", "kerb");
  for (int seed : {1, 2, 3, 4, 5, 6}) {
    config.sim.seed = seed;
    Truth truth(config);
    const TruthScene& scene = *record_of<TruthScene>(truth["truth/scene"]);
    const Image& cells = truth["truth/map_cells"];
    // The edge straight ahead.
    const TruthDrop& drop = scene.drop;
    const double part = -drop.left_x / (drop.right_x - drop.left_x), edge = drop.left_z + part * (drop.right_z - drop.left_z);
    ASSERT_GT(drop.depth, 0.29f);
    EXPECT_EQ(drop.across, 0);
    EXPECT_TRUE(cell(cells, 0, edge - 1e-3) == TruthCell::drop_off || cell(cells, 0, edge + 1e-3) == TruthCell::drop_off) << seed;
    for (double z = 1.2; z < edge - 0.15; z += 0.1) EXPECT_EQ(cell(cells, 0, z), TruthCell::free) << seed << " " << z;
    const double lowest_look = config.sim.pitch + std::atan(120 / (0.9 * 320));
    const double out_of_view = (config.sim.cameraHeight + drop.depth) / std::tan(lowest_look) + 0.05;
    // The line of sight over the edge meets the lower level there.
    const double seen_again = edge * (config.sim.cameraHeight + drop.depth) / config.sim.cameraHeight;
    for (double z = edge + 0.15; z < std::min(5.0, seen_again - 0.15); z += 0.1) {
      // A deep bottom at one's feet is below the picture.
      const TruthCell kind = cell(cells, 0, z);
      EXPECT_TRUE(kind == TruthCell::hidden || (z < out_of_view && kind == TruthCell::outside)) << seed << " " << z;
    }
    for (double z = seen_again + 0.2; z < 4.9; z += 0.1) EXPECT_EQ(cell(cells, 0, z), TruthCell::below) << seed << " " << z;
  }
}

TEST(SimGround, the_far_side_of_a_crest_is_hidden_where_it_falls_more_steeply_than_the_look_over_it) {
  int hidden = 0, seen = 0;
  for (double slope : {-6 * degree, -25 * degree}) {
    for (int seed = 1; seed <= 4; ++seed) {
      Config config;
      config.sim = small("empty", "ramp");
      config.sim.slope = slope;
      config.sim.seed = seed;
      Truth truth(config);
      const TruthScene& scene = *record_of<TruthScene>(truth["truth/scene"]);
      ASSERT_GE(scene.crest_m, 1.4);
      const double look = std::atan(scene.height_m / scene.crest_m);
      if (std::abs(look + slope) < 3 * degree) continue;
      const bool sees = -slope < look;
      ++(sees ? seen : hidden);
      for (double z = scene.crest_m + 0.15; z < 4.5; z += 0.1)
        EXPECT_EQ(cell(truth["truth/map_cells"], 0, z), sees ? TruthCell::free : TruthCell::hidden) << slope / degree << " " << z;
    }
  }
  EXPECT_GT(hidden, 0);
  EXPECT_GT(seen, 3);
}

TEST(SimGround, cells_agree_with_the_map_and_overhangs_are_no_obstacles) {
  for (int seed : {1, 2, 3}) {
    Config config;
    config.sim = small("overhangs");
    config.sim.pitch = 0.1;
    config.sim.seed = seed;
    Truth truth(config);
    int overhangs = 0;
    for (int row = 0; row < 50; ++row) {
      for (int column = 0; column < 51; ++column) {
        const auto kind = static_cast<TruthCell>(truth["truth/map_cells"].row<uint8_t>(row)[column]);
        overhangs += kind == TruthCell::overhang;
        // The count map knows no overhangs; apart from them what it has stands in or beside a cell that is said to be an obstacle.
        if (truth["truth/map"].row<int16_t>(row)[column] < 3) continue;
        bool explained = kind == TruthCell::overhang;
        for (int y = std::max(0, row - 1); y <= std::min(49, row + 1); ++y)
          for (int x = std::max(0, column - 1); x <= std::min(50, column + 1); ++x) {
            const auto near = static_cast<TruthCell>(truth["truth/map_cells"].row<uint8_t>(y)[x]);
            explained |= near == TruthCell::obstacle || near == TruthCell::overhang;
          }
        // Over what is hidden or outside there may hang something too.
        explained |= kind == TruthCell::hidden || kind == TruthCell::outside;
        EXPECT_TRUE(explained) << seed << ": " << row << ", " << column;
      }
    }
    EXPECT_GT(overhangs, 3) << seed;
  }
}

TEST(SimGround, the_floor_line_follows_ground_that_is_no_plane) {
  for (const char* shape : {"ramp", "crest", "slope"}) {
    Config config;
    config.sim = small("empty", shape);
    config.sim.slope = 0.12;
    config.sim.roughness = std::string(shape) == "slope" ? 0.03 : 0;
    config.sim.roll = 0.05;
    Truth truth(config);
    const int centre = config.sim.width / 2;
    int compared = 0;
    for (int v = 0; v < config.sim.height; ++v) {
      const int16_t d = truth["truth/disparity"].row<int16_t>(v)[centre];
      if (d < 60 || d >= 16 * 48) continue;
      EXPECT_NEAR(truth["truth/floor"].row<int16_t>(0)[d], v, 1.5) << shape;
      ++compared;
    }
    EXPECT_GT(compared, 80);
  }
}

TEST(SimGround, a_rover_is_not_driven_into_a_ditch) {
  Config config;
  config.sim = small("drive", "ditch");
  try {
    open_sim(config);
    FAIL();
  } catch (const SourceError& error) {
    EXPECT_EQ(error.exit_code, 78);
    EXPECT_NE(std::string(error.what()).find("ground = ditch"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace vdisp
