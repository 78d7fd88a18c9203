// ride_test.cpp: the driven robot: limits and collisions by arithmetic, people, glass, the expert, and worlds without a way out.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sim/ride.h"

#include <gtest/gtest.h>

#include <cstring>

#include "daemon/core/driver.h"
#include "daemon/sim/objects.h"
#include "daemon/sim/renderer.h"
#include "daemon/sim/shapes.h"
#include "daemon/sources/sim.h"

namespace vdisp::sim {
namespace {

constexpr const char* scenes[] = {"office", "garage", "rocks"};

sim_section parameters(const std::string& scene, int seed, const std::string& drive) {
  sim_section parameters;
  parameters.scene = scene;
  parameters.seed = seed;
  parameters.drive = drive;
  parameters.rate = 10;
  parameters.width = 160;
  parameters.height = 120;
  return parameters;
}

SceneObject wall(double x, double z, double width, double depth = 0.2) { return make(ObjectKind::wall, x, z, width, depth, 2, 0, 140); }

/// Nothing but what is given, and a robot that is commanded.
Ride ride(std::vector<SceneObject> objects, std::vector<Walker> walkers = {}, std::vector<SceneObject> panes = {}) {
  World world;
  world.objects = std::move(objects);
  world.panes = std::move(panes);
  world.walkers = std::move(walkers);
  return Ride(parameters("office", 1, "command"), world);
}

constexpr Order ahead{false, 0.5, 0};

TEST(Footprint, gaps_are_the_distances_of_the_borders) {
  const Footprint unit({0, 0}, 1, 1, 0);
  EXPECT_DOUBLE_EQ(unit.gap(Footprint({2, 0}, 1, 1, 0)), 1);
  EXPECT_DOUBLE_EQ(unit.gap(Footprint({2, 2}, 1, 1, 0)), std::sqrt(2));
  EXPECT_NEAR(unit.gap(Footprint({2, 0}, 1, 1, M_PI / 4)), 1.5 - std::sqrt(0.5), 1e-12);
  EXPECT_DOUBLE_EQ(unit.gap(Footprint({0.9, 0.9}, 1, 1, 0)), 0);
  EXPECT_DOUBLE_EQ(unit.gap(Spot{0.1, 0.2}), 0);
  EXPECT_DOUBLE_EQ(unit.gap(Spot{0.5, 1.5}), 1);
  EXPECT_FALSE(unit.meets(Footprint({1.001, 0}, 1, 1, 0)));
  EXPECT_TRUE(unit.meets(Footprint({0.999, 0}, 1, 1, 0)));
  EXPECT_NEAR(Footprint::disc({0, 0}, 0.5).gap(Spot{2, 0}), 1.5, 1e-12);
}

TEST(Footprint, a_strip_ahead_ends_at_the_first_thing_in_it) {
  const Footprint box({0.5, 3}, 0.4, 0.4, 0);
  EXPECT_NEAR(box.ahead({0, 0}, towards(0), 0.35, 9), 2.8, 1e-12);
  EXPECT_EQ(box.ahead({0, 0}, towards(0), 0.25, 9), 9) << "it lies beside the strip";
  EXPECT_EQ(box.ahead({0, 0}, towards(0), 0.35, 2), 2) << "and beyond what is asked for";
  EXPECT_EQ(box.ahead({0, 5}, towards(0), 0.35, 9), 9) << "behind";
  EXPECT_EQ(Footprint({0.3, 0}, 0.2, 4, 0).ahead({0, 0}, towards(0), 0.25, 9), 0) << "beside the spot itself";
  EXPECT_NEAR(box.ahead({0, 0}, towards(-std::atan2(0.5, 3)), 0.05, 9), std::hypot(0.5, 3) - 0.2, 0.02);
}

/// What is drawn of an object between the height that wheels climb and the robot's top, sampled along all edges; ground at 0.
std::vector<Spot> drawn(const SceneObject& o, uint32_t seed) {
  const Mesh mesh = shape(o, 0, seed);
  std::vector<Spot> spots;
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    const float* a = &mesh.vertices[mesh.triangles[i] * 3];
    const float* b = &mesh.vertices[mesh.triangles[i % 3 == 2 ? i - 2 : i + 1] * 3];
    for (int k = 0; k <= 20; ++k) {
      const auto at = [&](int axis) { return a[axis] + (b[axis] - a[axis]) * static_cast<float>(k) / 20; };
      if (-at(1) >= Robot::climbs && -at(1) <= Robot::height) spots.push_back({at(0), at(2)});
    }
  }
  return spots;
}

TEST(FloorPlan, what_is_drawn_is_solid_and_what_is_solid_is_drawn) {
  for (const char* scene : scenes)
    for (int seed : {2, 3, 301}) {
      const World world = make_world(parameters(scene, seed, "command"));
      const FloorPlan plan(world.objects, {}, 0, static_cast<uint32_t>(seed));
      double farthest = 0, widest = 0;
      size_t thing = 0;
      for (size_t i = 0; i < world.objects.size(); ++i) {
        const SceneObject& o = world.objects[i];
        if (o.bottom >= Robot::height || o.height <= Robot::climbs) continue;
        const Footprint& outline = plan.things()[thing++].outline;
        const std::vector<Spot> spots = drawn(o, bumps(static_cast<uint32_t>(seed), i));
        for (const Spot& spot : spots) farthest = std::max(farthest, outline.gap(spot));
        if (o.kind != ObjectKind::rock) continue;
        for (int k = 0; k < 64; ++k) {
          const Spot along = towards(k * M_PI / 32);
          const auto reach = [&](const auto& list) {
            double most = -1e9;
            for (const Spot& p : list) most = std::max(most, p.x * along.x + p.z * along.z);
            return most;
          };
          widest = std::max(widest, (reach(outline) - reach(spots)) / std::max(o.width, o.depth));
        }
      }
      EXPECT_EQ(thing, plan.things().size());
      EXPECT_LT(farthest, 1e-5) << scene << " " << seed << ": m that something is drawn beyond its outline";
      EXPECT_LT(widest, 0.03) << scene << " " << seed << ": of a rock's width, that its outline is wider than the rock";
    }
}

TEST(FloorPlan, people_are_as_wide_as_they_are_drawn) {
  People people({{{{0, 0}, {0, 20}}, 1, 0, 100}});
  std::vector<SceneObject> figures(People::parts);
  double reach = 0;
  for (int i = 0; i < 100; ++i) {
    people.step(0.03, {9, 9});
    people.draw(figures);
    for (const SceneObject& part : figures)
      for (const Spot& spot : drawn(part, 0)) reach = std::max(reach, distance(spot, people.spots()[0]));
  }
  EXPECT_GT(reach, 0.25);
  EXPECT_LT(reach, FloorPlan::girth / 2);
}

TEST(Robot, wheels_speed_up_and_brake_as_their_limits_say) {
  Robot robot;
  for (int i = 0; i < 30; ++i) robot.move(ahead, 0.01);
  EXPECT_NEAR(robot.speed(), 0.3, 1e-9);
  for (int i = 0; i < 70; ++i) robot.move(ahead, 0.01);
  EXPECT_NEAR(robot.speed(), 0.5, 1e-9);
  EXPECT_NEAR(robot.spot.z, 0.5 * 0.5 / 2 + 0.5 * 0.5, 0.006);
  const double before = robot.spot.z;
  for (int i = 0; i < 100; ++i) robot.move(Order{true, 0.5, 0.5}, 0.01);
  EXPECT_TRUE(robot.stands()) << "brake wins over what else is told";
  EXPECT_NEAR(robot.spot.z - before, 0.5 * 0.5 / (2 * Robot::braking), 0.004);
  EXPECT_EQ(robot.spot.x, 0);
  EXPECT_EQ(robot.heading, 0);
}

TEST(Robot, drives_circles_to_the_left_and_never_faster_than_a_wheel_can) {
  Robot robot;
  for (int i = 0; i < 1000; ++i) robot.move({false, 0.4, 0.8}, 0.01);
  EXPECT_NEAR(robot.speed(), 0.4, 1e-9);
  EXPECT_NEAR(robot.turn_rate(), 0.8, 1e-9);
  const Spot along = towards(robot.heading), centre{robot.spot.x - 0.5 * along.z, robot.spot.z + 0.5 * along.x};
  for (int i = 0; i < 300; ++i) {
    robot.move({false, 0.4, 0.8}, 0.01);
    EXPECT_NEAR(distance(robot.spot, centre), 0.5, 1e-5);
  }
  for (int i = 0; i < 300; ++i) {
    robot.move({false, 5, 9}, 0.01);
    EXPECT_LE(std::abs(robot.speed()) + std::abs(robot.turn_rate()) * Robot::wheel_base / 2, Robot::most_wheel_speed + 1e-9);
    EXPECT_LE(robot.turn_rate(), Robot::most_turn + 1e-9);
  }
  robot.move({false, std::nan(""), 0}, 0.2);
  EXPECT_LT(robot.speed(), 0.6) << "what is no number brakes";
}

TEST(Ride, a_wall_is_hit_where_the_robots_front_meets_it_and_counted_once) {
  Ride ride_ = ride({wall(0, 2.1, 6)});
  int frames = 0;
  while (!ride_.report().collided && ++frames < 100) ride_.step(ahead);
  const RobotReport hit = ride_.report();
  ASSERT_TRUE(hit.collided);
  EXPECT_EQ(hit.collisions, 1u);
  EXPECT_STREQ(hit.met, "wall");
  EXPECT_NEAR(hit.x, 2 - Robot::side / 2, 0.006) << "the robot's front at the wall's";
  EXPECT_NEAR(hit.clearance, 0, 0.006);
  EXPECT_EQ(hit.speed, 0);
  EXPECT_NEAR(frames / 10.0, 1.8 / 0.5 + 0.25, 0.11) << "1.8 m at 0.5 m/s, a quarter of a second lost speeding up";
  ride_.step(ahead);
  EXPECT_FALSE(ride_.report().collided);
  EXPECT_EQ(ride_.report().collisions, 1u);
  EXPECT_GE(ride_.plan().gap(ride_.robot().spot, 9), Ride::refuge_room) << "put back where there is room";
  EXPECT_GT(std::abs(ride_.report().yaw), 1) << "and turned away";
  EXPECT_EQ(ride_.report().speed, 0) << "at rest: the order was made of the picture before";
  ride_.step(ahead);
  EXPECT_GT(ride_.report().speed, 0);
}

TEST(Ride, glass_is_solid_and_pebbles_are_not) {
  Ride glass = ride({}, {}, {wall(0, 2.1, 6)});
  for (int i = 0; i < 60; ++i) glass.step(ahead);
  EXPECT_GE(glass.report().collisions, 1u);
  EXPECT_STREQ(glass.report().met, "glass");
  SceneObject pebble = make(ObjectKind::rock, 0, 1, 0.2, 0.2, 0.05, 0, 100), lamp = make(ObjectKind::beam, 0, 2, 2, 2, 1, 0, 100),
              table = make(ObjectKind::beam, 0, 6, 2, 2, 0.75, 0, 100);
  lamp.bottom = 0.81;
  table.bottom = 0.7;
  Ride open = ride({pebble, lamp, table});
  for (int i = 0; i < 90; ++i) open.step(ahead);
  EXPECT_EQ(open.report().collisions, 0u) << open.report().met;
  for (int i = 0; i < 30; ++i) open.step(ahead);
  EXPECT_STREQ(open.report().met, "beam") << "the robot is 0.8 m tall";
}

TEST(Ride, a_turn_on_the_spot_meets_what_the_corners_reach) {
  Ride wide = ride({wall(0.2 + 0.1 + 0.09, 0, 0.2, 4)}), tight = ride({wall(0.2 + 0.1 + 0.07, 0, 0.2, 4)});
  for (int i = 0; i < 40; ++i) {
    wide.step({false, 0, 0.8});
    tight.step({false, 0, 0.8});
  }
  EXPECT_EQ(wide.report().collisions, 0u) << "corners reach 0.083 m beyond the sides";
  EXPECT_GE(tight.report().collisions, 1u);
}

TEST(Ride, people_walk_and_stop_before_a_robot_that_stands) {
  Ride ride_ = ride({}, {{{{0, 6}, {0, -6}}, 1, 0, 100}});
  double nearest = 9;
  for (int i = 0; i < 600; ++i) {
    ride_.step(Order{});
    nearest = std::min(nearest, ride_.report().clearance);
  }
  EXPECT_EQ(ride_.report().collisions, 0u);
  EXPECT_NEAR(nearest, People::respect - Robot::side / 2 - FloorPlan::girth / 2, 0.11);
  EXPECT_LT(ride_.people().spots()[0].z, 6);
  Ride into = ride({}, {{{{0, 6}, {0, -6}}, 1, 0, 100}});
  for (int i = 0; i < 100 && into.report().collisions == 0; ++i) into.step(ahead);
  EXPECT_STREQ(into.report().met, "person") << "a robot that drives on runs into them";
}

TEST(Ride, without_progress_it_is_stuck_and_goes_on_elsewhere) {
  Ride ride_ = ride({}, {{{{5, 6}, {5, -6}}, 1, 0, 100}});
  for (int i = 0; i < 299; ++i) ride_.step(Order{});
  EXPECT_EQ(ride_.report().stuck_times, 0u);
  for (int i = 0; i < 2; ++i) ride_.step(Order{});
  EXPECT_EQ(ride_.report().stuck_times, 1u);
  ride_.step(Order{});
  EXPECT_GT(distance(ride_.robot().spot, {}), 0.5);
  EXPECT_EQ(ride_.report().travelled, 0) << "being put somewhere is no way travelled";
}

/// What somebody stands on who walks so slowly that he is there all the time.
Walker stands(double x, double z) { return {{{x, z}, {x, z + 0.001}}, 1e-6, 0, 100}; }

TEST(Ride, is_put_back_where_nobody_stands_or_waits_until_there_is_room) {
  // A person walks up behind the robot and stays on the only place it can be put back to.
  Ride ride_ = ride({wall(0, 0.9, 6)}, {{{{0, -3}, {0, 40}}, 0.9, 0, 100}});
  int frames = 0, waited = 0;
  while (ride_.report().collisions == 0 && ++frames < 300) ride_.step(frames < 24 ? Order{} : ahead);
  ASSERT_STREQ(ride_.report().met, "wall");
  ASSERT_LT(ride_.plan().gap(Spot{}, 9), Ride::refuge_room) << "the place behind is taken";
  const double hit = ride_.robot().spot.z;
  while (ride_.robot().spot.z == hit && ++waited < 300) {
    ride_.step(ahead);
    EXPECT_EQ(ride_.report().collisions, 1u) << "while it waits it does nothing";
    EXPECT_EQ(ride_.report().speed, 0);
  }
  EXPECT_GT(waited, 1);
  ASSERT_LT(waited, 300) << "people who stand before it walk back";
  EXPECT_GE(ride_.plan().gap(ride_.robot().spot, 9), Ride::refuge_room);
}

TEST(Ride, a_stuck_robot_goes_on_where_nobody_stands) {
  // A closet in which few places have room, and people on most of them.
  std::vector<SceneObject> walls{wall(0, 0.8, 3.4), wall(0, -0.8, 3.4), wall(-1.7, 0, 0.2, 3.4), wall(1.7, 0, 0.2, 3.4)};
  Ride freed = ride(walls, {stands(0.9, 0)});
  for (int i = 0; i < 3300; ++i) {
    const Spot before = freed.robot().spot;
    freed.step(Order{});
    if (distance(before, freed.robot().spot) > 0) {
      EXPECT_GE(freed.plan().gap(freed.robot().spot, 9), Ride::refuge_room);
    }
  }
  EXPECT_EQ(freed.report().stuck_times, 10u);
  Ride full = ride(walls, {stands(-0.9, 0), stands(0, 0), stands(0.9, 0)});
  for (int i = 0; i < 650; ++i) full.step(Order{});
  EXPECT_EQ(distance(full.robot().spot, {}), 0) << "with no room anywhere it stays where it is";
}

TEST(Expert, labels_what_is_near_by_the_side_that_is_open) {
  const auto label = [](std::vector<SceneObject> objects) { return ride(std::move(objects)).report().steering; };
  EXPECT_EQ(label({wall(0, 1.7, 4)}), Steering::forward) << "1.6 m to its face";
  EXPECT_NE(label({wall(0, 1.5, 4)}), Steering::forward) << "1.4 m to its face";
  EXPECT_EQ(label({wall(0.6, 1, 2), wall(1.5, 0, 0.2, 4)}), Steering::turn_left);
  EXPECT_EQ(label({wall(-0.6, 1, 2), wall(-1.5, 0, 0.2, 4)}), Steering::turn_right);
  EXPECT_EQ(label({wall(0.8, 0.8, 0.9, 0.9)}), Steering::forward) << "beside the strip";
}

TEST(Expert, a_label_knows_nothing_of_the_frames_before_and_of_what_is_out_of_view) {
  // Before a wall, in view 3 m of room on the right and less on the left; what lies beside and behind has no say in it.
  const std::vector<SceneObject> seen{wall(0, 1.2, 1), wall(-1.2, 1.8, 1.4)};
  for (const double aside : {-1.0, 1.0}) {
    std::vector<SceneObject> objects = seen;
    objects.push_back(wall(aside, -0.6, 0.2, 1.6));
    EXPECT_EQ(ride(objects).report().steering, Steering::turn_right) << aside;
  }
  Ride ride_ = ride({wall(0, 1.2, 1), wall(-1.2, 1.8, 1.4)});
  for (int i = 0; i < 40; ++i) {
    ride_.step({false, 0, i / 10 % 2 ? 0.8 : -0.8});
    EXPECT_EQ(ride_.report().steering, Expert(1, 0).judge(ride_.plan(), ride_.robot(), 0).label) << i;
  }
  EXPECT_GT(ride_.report().changes, 0u);
}

TEST(Expert, keeps_its_direction_until_the_way_is_free) {
  Ride ride_ = ride({wall(0.3, 0.9, 4), wall(0, -1.5, 6), wall(-3, 0, 0.2, 6), wall(3, 0, 0.2, 6)});
  Expert expert(1, 0);
  const auto steering = [&] { return expert.judge(ride_.plan(), ride_.robot(), 0.1).steering; };
  const Steering first = steering();
  ASSERT_NE(first, Steering::forward);
  for (int i = 0; i < 80 && steering() != Steering::forward; ++i) {
    EXPECT_EQ(expert.judgement().steering, first);
    ride_.step({false, 0, first == Steering::turn_left ? 0.8 : -0.8});
  }
  EXPECT_EQ(expert.judgement().steering, Steering::forward);
}

TEST(Worlds, have_no_way_out_and_room_to_drive) {
  std::vector<int> seeds{103, 105, 107, 301, 303, 305, 307};
  for (int seed = 1; seed <= 16; ++seed) seeds.push_back(seed);
  for (int seed = 201; seed <= 223; seed += 2) seeds.push_back(seed);
  for (const char* scene : scenes)
    for (const int seed : seeds) {
      sim_section asked = parameters(scene, seed, "command");
      asked.glass = seed % 3 == 0;
      const World world = make_world(asked);
      const FloorPlan plan(world.objects, world.panes, 0, static_cast<uint32_t>(seed));
      // A robot that squeezes through whatever is wider than it.
      const Reach reach(plan, {}, world.middle, world.extent + 1, Robot::side / 2);
      EXPECT_FALSE(reach.open()) << scene << " " << seed;
      EXPECT_GT(reach.area(), asked.glass ? 15 : 40) << scene << " " << seed;
      EXPECT_GE(plan.gap(Spot{}, 9), Ride::refuge_room) << scene << " " << seed << ": at the start";
    }
}

TEST(Worlds, the_expert_drives_through_without_a_collision_with_and_without_exploring) {
  for (const char* scene : scenes)
    for (const double exploration : {0.0, 0.6}) {
      sim_section asked = parameters(scene, 4, "expert");
      asked.exploration = exploration;
      Ride ride_(asked, make_world(asked));
      double nearest = 9;
      for (int i = 0; i < 1800; ++i) {
        ride_.step(Order{});
        nearest = std::min(nearest, ride_.report().clearance);
      }
      EXPECT_EQ(ride_.report().collisions, 0u) << scene << " " << exploration << ": " << ride_.report().met;
      EXPECT_EQ(ride_.report().stuck_times, 0u) << scene << " " << exploration;
      EXPECT_GT(ride_.report().travelled, exploration > 0 ? 20 : 40) << scene;
      if (exploration > 0) {
        EXPECT_LT(nearest, 0.2) << scene << ": views from near by";
      }
    }
}

TEST(Worlds, the_same_seed_and_orders_make_the_same_ride) {
  const auto drive = [](int seed) {
    const sim_section asked = parameters("office", seed, "command");
    Ride ride_(asked, make_world(asked));
    for (int i = 0; i < 300; ++i) ride_.step({false, 0.5, 0.5 * std::sin(0.05 * i)});
    return ride_.report();
  };
  const RobotReport one = drive(7), again = drive(7), other = drive(9);
  EXPECT_EQ(std::memcmp(&one, &again, sizeof one), 0);
  EXPECT_NE(one.travelled, other.travelled);
}

struct Views {
  std::vector<std::byte> left, right;
  explicit Views(Simulator& simulator) : left(160 * 120), right(160 * 120) { simulator.render(0, left.data(), right.data(), 160); }
};

TEST(Worlds, glass_changes_what_is_hit_and_nothing_of_what_is_seen) {
  for (const char* scene : scenes) {
    sim_section asked = parameters(scene, 5, "command");
    const auto without = make_simulator(asked);
    asked.glass = true;
    const auto with = make_simulator(asked);
    const auto panes = [](const Simulator& simulator) {
      const std::vector<WorldOutline> outlines = simulator.outlines();
      return std::count_if(outlines.begin(), outlines.end(), [](const WorldOutline& o) { return std::strcmp(o.what, "glass") == 0; });
    };
    EXPECT_EQ(panes(*without), 0) << scene;
    EXPECT_GT(panes(*with), 0) << scene;
    for (int i = 0; i < 3; ++i) {
      const Views a(*with), b(*without);
      EXPECT_EQ(a.left, b.left) << scene;
      EXPECT_EQ(a.right, b.right) << scene;
      with->step(Order{});
      without->step(Order{});
    }
  }
}

TEST(Worlds, pictures_show_what_the_robot_and_the_people_do) {
  const sim_section asked = parameters("office", 2, "command");
  const auto stands = make_simulator(asked), moves = make_simulator(asked);
  const Views first(*stands), same(*moves);
  EXPECT_EQ(first.left, same.left);
  for (int i = 0; i < 20; ++i) {
    stands->step(Order{});
    moves->step(ahead);
  }
  const Views later(*stands), elsewhere(*moves);
  EXPECT_NE(later.left, elsewhere.left);
  EXPECT_NEAR(moves->rover(20).x, 2 * 0.5 - 0.125, 0.06);
  EXPECT_EQ(stands->rover(20).x, 0);
  const TruthView& truth = moves->truth(20);
  EXPECT_NEAR(truth.scene.x_m, moves->robot()->x, 1e-9);
  // The same number has the same noise: what changes before a robot that stands is somebody who walks.
  const auto waits = make_simulator(asked);
  int steps = 0;
  while (Views(*waits).left == first.left && ++steps < 600) waits->step(Order{});
  EXPECT_GT(steps, 0);
  EXPECT_LT(steps, 600) << "nobody came in sight in a minute";
  for (int i = 0; i < 5; ++i) waits->step(Order{});
  EXPECT_EQ(waits->robot()->travelled, 0);
}

/// What the tree said, by the number of the frame it said it in.
struct Says final : ImageProcessor {
  std::vector<ImageSpec> check(std::span<const ImageSpec>) override { return {record_spec<DriveCommand>()}; }
  Outcome process(std::span<const Image* const> in, std::span<Image* const> out) noexcept override {
    const int64_t frame = in[0]->timestamp_ns / 100'000'000;
    DriveCommand& command = make_record<DriveCommand>(*out[0]);
    command.speed = 0.5;
    if (frame < 20 || frame >= 40) {
      out[0]->reason = Reason::no_floor_line;
      return Outcome::invalid;
    }
    return Outcome::valid;
  }
};

TEST(SimSource, the_robot_does_in_a_frame_what_the_tree_said_in_the_last_and_brakes_where_it_was_blind) {
  Config config;
  config.sim = parameters("garage", 1, "command");
  config.sim.odometry = true;
  auto source = open_sim(config);
  StereoSource& stereo = *source;
  ASSERT_TRUE(stereo.driven());
  Driver driver(1);
  const auto camera =
      driver.add_set({"camera/left", "camera/right"}, std::move(source), {driver.last("drive", record_spec<DriveCommand>())}, Need::always);
  driver.add("drive", std::make_unique<Says>(), {camera[0]}, Need::always);
  driver.connect([](const std::string&, const ImageSpec& spec) { return std::make_unique<BufferOutlet>(spec); });
  std::vector<double> x;
  for (int frame = 0; frame < 60; ++frame) {
    driver.step();
    x.push_back(stereo.odometry()->x);
  }
  EXPECT_EQ(x[20], 0) << "said in frame 20, done in the time to frame 21";
  EXPECT_GT(x[21], 0);
  EXPECT_NEAR(x[31] - x[30], 0.05, 1e-6) << "0.5 m/s";
  EXPECT_NEAR(x[40] - x[39], 0.05, 1e-6);
  EXPECT_LT(x[41] - x[40], 0.045);
  EXPECT_EQ(x[59], x[50]) << "it stands";
  EXPECT_NEAR(x[59] - x[40], 0.5 * 0.5 / (2 * Robot::braking), 0.01);
}

}  // namespace
}  // namespace vdisp::sim
