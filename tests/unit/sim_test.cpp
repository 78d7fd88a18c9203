// sim_test.cpp: the simulator's pictures, calibration and truth agree with each other and with arithmetic.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "daemon/sim/renderer.h"
#include "daemon/sim/scene.h"
#include "daemon/sim/shade.h"
#include "daemon/sim/texture.h"
#include "daemon/sources/sim.h"

namespace vdisp {
namespace {

struct Pair {
  cv::Mat left, right;
};

sim_section small(const std::string& scene) {
  sim_section parameters;
  parameters.scene = scene;
  parameters.width = 320;
  parameters.height = 240;
  return parameters;
}

sim_section perfect(const std::string& scene) {
  sim_section parameters = small(scene);
  parameters.noise = parameters.distortion = 0;
  parameters.gain = 1;
  return parameters;
}

Pair render(sim::Simulator& simulator, const sim_section& parameters, uint64_t frame) {
  Pair pair{cv::Mat(parameters.height, parameters.width, CV_8U), cv::Mat(parameters.height, parameters.width, CV_8U)};
  simulator.render(frame, reinterpret_cast<std::byte*>(pair.left.data), reinterpret_cast<std::byte*>(pair.right.data), pair.left.step);
  return pair;
}

bool same(const cv::Mat& a, const cv::Mat& b) { return std::memcmp(a.data, b.data, a.total()) == 0; }

/// Mean difference between left pixels and those of the right image at their true disparity, where the right camera sees them.
double photo_error(const Pair& pair, const sim::TruthView& truth, const StereoView& view) {
  double sum = 0;
  int count = 0;
  for (int v = 2; v < truth.height - 2; ++v) {
    std::vector<double> nearest(static_cast<size_t>(truth.width), 0.0), disparity(nearest);
    for (int u = 0; u < truth.width; ++u) {
      const float z = truth.depth[static_cast<size_t>(v) * truth.width + u];
      disparity[u] = z > 0 ? view.disparity(z) : 0;
      for (int x = static_cast<int>(u - disparity[u]) - 1; x <= static_cast<int>(u - disparity[u]) + 2; ++x)
        if (x >= 0 && x < truth.width) nearest[x] = std::max(nearest[x], disparity[u]);
    }
    for (int u = 2; u < truth.width - 2; ++u) {
      const double x = u - disparity[u];
      // Beside an edge in either view a pixel is of both sides.
      const bool edge = std::abs(disparity[u + 1] - disparity[u]) > 0.5 || std::abs(disparity[u - 1] - disparity[u]) > 0.5;
      if (disparity[u] <= 0 || x < 1 || edge || nearest[static_cast<size_t>(x)] > disparity[u] + 0.5) continue;
      const int i = static_cast<int>(x);
      const double part = x - i, there = pair.right.at<uint8_t>(v, i) * (1 - part) + pair.right.at<uint8_t>(v, i + 1) * part;
      sum += std::abs(there - pair.left.at<uint8_t>(v, u));
      ++count;
    }
  }
  EXPECT_GT(count, truth.width * truth.height / 3);
  return sum / count;
}

Pair rectified(const Pair& raw, const Calibration& calibration) {
  Pair out;
  for (size_t side = 0; side < 2; ++side) {
    const RawCamera& camera = (*calibration.raw)[side];
    cv::Mat map_x, map_y;
    cv::initUndistortRectifyMap(cv::Mat(camera.k, true).reshape(1, 3), cv::Mat(camera.distortion, true),
                                cv::Mat(camera.rectification, true).reshape(1, 3), cv::Mat(camera.projection, true).reshape(1, 3),
                                raw.left.size(), CV_32FC1, map_x, map_y);
    cv::remap(side == 0 ? raw.left : raw.right, side == 0 ? out.left : out.right, map_x, map_y, cv::INTER_LINEAR);
  }
  return out;
}

TEST(Sim, the_same_parameters_give_the_same_bytes) {
  const sim_section parameters = small("drive");
  const auto a = sim::make_simulator(parameters), b = sim::make_simulator(parameters);
  const Pair late = render(*a, parameters, 40), first = render(*a, parameters, 3), again = render(*b, parameters, 3);
  EXPECT_TRUE(same(first.left, again.left));
  EXPECT_TRUE(same(first.right, again.right));
  EXPECT_FALSE(same(first.left, late.left));
}

TEST(Sim, another_seed_gives_another_scene) {
  sim_section parameters = small("flat");
  const auto a = sim::make_simulator(parameters);
  parameters.seed = 2;
  const auto b = sim::make_simulator(parameters);
  EXPECT_NE(a->truth(0).scene.objects[0].x, b->truth(0).scene.objects[0].x);
}

TEST(Sim, every_instruction_set_draws_the_same) {
  const sim::Textures textures = sim::make_textures(5);
  sim::GroundLight light;
  light.x0 = light.z0 = -10;
  light.cells_per_m = 20;
  light.packed =
      sim::pack(std::vector<uint8_t>(size_t{sim::GroundLight::side} * sim::GroundLight::side, 200), sim::GroundLight::side, false);
  sim::ObjectTable table;
  for (auto* column : {&table.x, &table.y, &table.z, &table.cos_yaw, &table.sin_yaw, &table.shift}) column->push_back(0.6f);
  table.brightness.push_back(120);
  table.contrast.push_back(1);
  table.texels_per_m.push_back(300);
  table.texture.push_back(sim::Textures::words);
  sim::Look look{{1, 0, 0, 0, 0.96f, 0.26f, 0, -0.26f, 0.96f},
                 0.1f,
                 -0.8f,
                 0.2f,
                 0.1f,
                 1,
                 1 / 576.f,
                 -0.5f,
                 -0.7f,
                 -0.5f,
                 1,
                 1.05f,
                 3,
                 99,
                 textures.texels.data(),
                 &table,
                 &light};
  std::array<float, sim::Batch::size> x, y;
  sim::Chance chance(3);
  std::generate(x.begin(), x.end(), [&] { return static_cast<float>(chance.between(-0.6, 0.6)); });
  std::generate(y.begin(), y.end(), [&] { return static_cast<float>(chance.between(-0.5, 0.5)); });
  std::array<std::array<uint8_t, sim::Batch::size>, 2> out;
  for (size_t which = 0; which < 2; ++which) {
    const sim::Shader shader = which == 0 ? sim::plain_shader() : sim::choose_shader();
    sim::Batch batch{};
    shader.aim(look, x.data(), y.data(), batch);
    for (int i = 0; i < sim::Batch::size; i += 3) {
      batch.object[i] = 0;
      batch.t[i] = 2;
      batch.nx[i] = 0.3f;
      batch.nz[i] = -0.8f;
    }
    shader.colour(look, true, batch);
    shader.expose(look, batch, 1234, 2048, out[which].data());
  }
  EXPECT_EQ(out[0], out[1]);
  EXPECT_GT(*std::max_element(out[0].begin(), out[0].end()), *std::min_element(out[0].begin(), out[0].end()) + 50);
}

TEST(Sim, disparity_of_flat_ground_is_the_closed_form) {
  const sim_section parameters = perfect("empty");
  const auto simulator = sim::make_simulator(parameters);
  const StereoView& view = simulator->calibration().view;
  EXPECT_DOUBLE_EQ(view.f, 288);
  const FloorLine line = floor_line(view, parameters.cameraHeight, parameters.pitch);
  const sim::TruthView& truth = simulator->truth(7);
  for (int v = 60; v < truth.height; v += 9)
    for (int u = 0; u < truth.width; u += 31) {
      const float z = truth.depth[static_cast<size_t>(v) * truth.width + u];
      ASSERT_GT(z, 0);
      EXPECT_NEAR(line.row(view.disparity(z)), v, 0.01);
    }
}

TEST(Sim, objects_are_seen_where_the_truth_lists_them) {
  sim_section parameters = perfect("obstacles");
  parameters.roll = 0.1;
  const auto simulator = sim::make_simulator(parameters);
  const StereoView& view = simulator->calibration().view;
  const sim::TruthView& truth = simulator->truth(11);
  ASSERT_EQ(truth.scene.count, 5u);
  std::array<int, 6> seen{};
  for (int v = 0; v < truth.height; ++v)
    for (int u = 0; u < truth.width; ++u) {
      const size_t pixel = static_cast<size_t>(v) * truth.width + u;
      if (truth.object[pixel] < 1 || truth.object[pixel] > 5) continue;
      const TruthObject& o = truth.scene.objects[truth.object[pixel] - 1];
      ++seen[truth.object[pixel]];
      const Point h = horizontal(view.point(u, v, view.disparity(truth.depth[pixel])), parameters.pitch, parameters.roll);
      const double along = (h.x - o.x) * std::cos(o.yaw) + (h.z - o.z) * std::sin(o.yaw),
                   aside = (h.z - o.z) * std::cos(o.yaw) - (h.x - o.x) * std::sin(o.yaw);
      const double up = parameters.cameraHeight - h.y, slack = 0.002;
      ASSERT_LT(std::abs(along), o.width / 2 + slack);
      ASSERT_LT(std::abs(aside), o.depth / 2 + slack);
      ASSERT_LT(up, o.height + slack);
      ASSERT_NEAR(up, truth.elevation[pixel], slack);
      if (o.kind == ObjectKind::box || o.kind == ObjectKind::wall) {
        const double inside = std::min({o.width / 2 - std::abs(along), o.depth / 2 - std::abs(aside), o.height - up});
        ASSERT_LT(inside, slack) << "a point within a box, not on it";
      }
    }
  for (int i = 1; i <= 5; ++i) EXPECT_GT(seen[i], 100) << i;
}

TEST(Sim, the_right_image_is_the_left_one_moved_by_the_true_disparity) {
  for (const char* scene : {"obstacles", "empty"}) {
    const sim_section parameters = perfect(scene);
    const auto simulator = sim::make_simulator(parameters);
    const Pair pair = render(*simulator, parameters, 2);
    const double error = photo_error(pair, simulator->truth(2), simulator->calibration().view);
    EXPECT_LT(error, 2.0) << scene;
    EXPECT_GT(photo_error(pair, simulator->truth(2), {simulator->calibration().view.f, 160, 120, 0.07, 0}), 4 * error)
        << "any disparity would do";
  }
}

TEST(Sim, opencv_rectifies_the_raw_images_by_the_calibration) {
  for (double distortion : {0.2, 0.5}) {
    sim_section parameters = perfect("obstacles");
    const auto ideal = sim::make_simulator(parameters);
    parameters.distortion = distortion;
    const auto real = sim::make_simulator(parameters);
    const Pair raw = render(*real, parameters, 2), straight = rectified(raw, real->calibration()), goal = render(*ideal, parameters, 2);
    EXPECT_LT(photo_error(straight, real->truth(2), real->calibration().view), 4.0);
    EXPECT_GT(photo_error(raw, real->truth(2), real->calibration().view), 8.0) << "rectification has no work to do";
    const cv::Rect inner(8, 8, 304, 224);
    EXPECT_LT(cv::norm(straight.left(inner), goal.left(inner), cv::NORM_L1) / inner.area(), 4.0);
    EXPECT_LT(cv::norm(straight.right(inner), goal.right(inner), cv::NORM_L1) / inner.area(), 4.0);
    EXPECT_EQ(cv::countNonZero(straight.left), parameters.width * parameters.height) << "the rectified view has empty corners";
  }
}

TEST(Sim, noise_and_gain_are_those_asked_for) {
  sim_section parameters = perfect("wall");
  const auto clean = sim::make_simulator(parameters);
  parameters.noise = 6;
  parameters.gain = 1.2;
  const auto noisy = sim::make_simulator(parameters);
  const Pair a = render(*clean, parameters, 1), b = render(*noisy, parameters, 1);
  cv::Mat difference;
  cv::subtract(b.left, a.left, difference, cv::noArray(), CV_32F);
  cv::Scalar mean, deviation;
  cv::meanStdDev(difference, mean, deviation);
  EXPECT_NEAR(mean[0], 0, 0.1);
  EXPECT_NEAR(deviation[0], 6, 0.2);
  EXPECT_NEAR(cv::mean(b.right)[0] / cv::mean(a.right)[0], 1.2, 0.01);
  EXPECT_GT(cv::norm(render(*noisy, parameters, 1).left, render(*noisy, parameters, 2).left, cv::NORM_L1), 1e5) << "noise stands still";
}

TEST(Sim, pitch_roll_and_height_are_the_parameters_on_the_slope_too) {
  sim_section parameters = small("drive");
  parameters.pitch = 0.4;
  parameters.roll = -0.07;
  parameters.cameraHeight = 1.1;
  parameters.slope = 0.1;
  const sim::Scene scene(parameters);
  for (uint64_t frame : {0u, 30u, 200u, 900u}) {
    sim::TruthView view;
    std::vector<uint8_t> numbers(scene.objects().size());
    scene.describe(scene.pose(frame), view, numbers);
    EXPECT_NEAR(view.scene.pitch_rad, 0.4, 1e-9);
    EXPECT_NEAR(view.scene.roll_rad, -0.07, 1e-9);
    EXPECT_NEAR(view.scene.height_m, 1.1, 1e-9);
  }
  sim::TruthView view;
  std::vector<uint8_t> numbers(scene.objects().size());
  scene.describe(scene.pose(0), view, numbers);
  EXPECT_NEAR(view.scene.slope_rad, 0.1, 0.01);
}

TEST(Sim, the_rover_drives_round_without_touching_anything) {
  for (int seed = 1; seed <= 5; ++seed) {
    sim_section parameters = small("drive");
    parameters.seed = seed;
    const sim::Scene scene(parameters);
    int tall = 0;
    for (const sim::SceneObject& o : scene.objects()) tall += o.height > 0.2;
    EXPECT_GT(tall, 25) << seed;
    for (uint64_t frame = 0; frame < 3300; frame += 10) {
      const Point at = scene.pose(frame).position;
      for (const sim::SceneObject& o : scene.objects()) {
        if (o.height < 0.2) continue;
        const double dx = at.x - o.x, dz = at.z - o.z;
        const double along = std::abs(dx * std::cos(o.yaw) + dz * std::sin(o.yaw)) - o.width / 2,
                     aside = std::abs(dz * std::cos(o.yaw) - dx * std::sin(o.yaw)) - o.depth / 2;
        ASSERT_GT(std::hypot(std::max(along, 0.0), std::max(aside, 0.0)), 0.6) << "seed " << seed << " frame " << frame;
      }
    }
  }
}

TEST(Sim, flat_scenes_have_obstacles_of_all_sizes_in_reach) {
  std::map<ObjectKind, int> kinds;
  int small_ones = 0;
  for (int seed = 0; seed < 50; ++seed) {
    sim_section parameters = small("flat");
    parameters.seed = seed;
    int found = 0;
    const sim::Scene scene(parameters);
    EXPECT_GE(scene.objects().size(), 3u) << seed;
    EXPECT_LE(scene.objects().size(), 8u) << seed;
    for (const sim::SceneObject& o : scene.objects()) {
      EXPECT_GT(o.z - o.radius(), 1.0);
      EXPECT_LE(o.z, 5.0);
      found += o.width >= 0.3 && o.height >= 0.3;
      small_ones += o.height <= 0.15;
      ++kinds[o.kind];
    }
    EXPECT_GE(found, 1) << seed;
  }
  EXPECT_GE(small_ones, 50);
  EXPECT_EQ(kinds.size(), 4u);
}

/// The whole source in a tree: steps it and keeps the last image of each topic.
class Tree {
 public:
  explicit Tree(const Config& config) : driver_(1) {
    auto source = open_sim(config);
    StereoSource* stereo = source.get();
    const auto cameras = driver_.add_set({"camera/left", "camera/right"}, std::move(source), {}, Need::always);
    stereo->add_truth(driver_, cameras[0]);
    driver_.connect([](const std::string&, const ImageSpec& spec) { return std::make_unique<BufferOutlet>(spec); });
    driver_.need_all();
    driver_.set_viewer([this](const Topic& topic, const Image& image) { images_[topic.name] = &image; });
  }
  void step() { ASSERT_EQ(driver_.step(), Outcome::valid); }
  const Image& operator[](const std::string& topic) { return *images_.at(topic); }

 private:
  Driver driver_;
  std::map<std::string, const Image*> images_;
};

TEST(SimSource, frames_are_those_of_the_renderer_in_order) {
  Config config;
  config.sim = small("flat");
  config.sim.rate = 25;
  Tree tree(config);
  const auto simulator = sim::make_simulator(config.sim);
  for (uint64_t frame = 0; frame < 5; ++frame) {
    tree.step();
    const Pair pair = render(*simulator, config.sim, frame);
    const Image& left = tree["camera/left"];
    EXPECT_EQ(left.timestamp_ns, static_cast<int64_t>(frame) * 40'000'000);
    EXPECT_TRUE(left.flags & flag_synthetic);
    EXPECT_EQ(std::memcmp(left.row<uint8_t>(0), pair.left.data, pair.left.total()), 0);
    EXPECT_EQ(std::memcmp(tree["camera/right"].row<uint8_t>(0), pair.right.data, pair.right.total()), 0);
  }
}

TEST(SimSource, the_map_has_the_tall_obstacles_and_nothing_else) {
  for (int seed = 1; seed <= 3; ++seed) {
    Config config;
    config.sim = small("flat");
    config.sim.seed = seed;
    Tree tree(config);
    tree.step();
    const Image& map = tree["truth/map"];
    ASSERT_EQ(map.spec, (ImageSpec{Pixel::count16, 0, 51, 50}));
    const TruthScene& scene = *record_of<TruthScene>(tree["truth/scene"]);
    const auto reach = [&](const TruthObject& o, double x, double z) {
      const double along = std::abs((x - o.x) * std::cos(o.yaw) + (z - o.z) * std::sin(o.yaw)),
                   aside = std::abs((z - o.z) * std::cos(o.yaw) - (x - o.x) * std::sin(o.yaw));
      return std::max(along - o.width / 2, aside - o.depth / 2);
    };
    std::array<int, TruthScene::capacity> cells{}, pixels{};
    for (int row = 0; row < 50; ++row)
      for (int column = 0; column < 51; ++column) {
        if (map.row<int16_t>(row)[column] == 0) continue;
        const double x = (column + 0.5) * 0.1 - 2.55, z = (49 - row + 0.5) * 0.1;
        bool explained = false;
        for (uint32_t i = 0; i < scene.count; ++i) {
          if (scene.objects[i].height < 0.2f || reach(scene.objects[i], x, z) > 0.071) continue;
          ++cells[i];
          explained = true;
        }
        EXPECT_TRUE(explained) << "nothing stands at " << x << ", " << z;
      }
    for (int v = 0; v < config.sim.height; ++v)
      for (int u = 0; u < config.sim.width; ++u) {
        const uint8_t object = tree["truth/object"].row<uint8_t>(v)[u];
        if (object >= 1 && object <= scene.count) ++pixels[object - 1];
      }
    for (uint32_t i = 0; i < scene.count; ++i) {
      const TruthObject& o = scene.objects[i];
      if (o.height < 0.25f || pixels[i] < 300 || o.z > 4.5f || std::abs(o.x) > 2) continue;
      EXPECT_GT(cells[i], 0) << "object " << i + 1;
    }
  }
}

TEST(SimSource, the_floor_line_lies_on_the_ground_that_is_seen) {
  for (double slope : {0.0, 0.15, -0.1}) {
    Config config;
    config.sim = small("empty");
    config.sim.slope = slope;
    config.sim.roll = 0.08;
    Tree tree(config);
    tree.step();
    const int centre = config.sim.width / 2;
    const int16_t* floor = tree["truth/floor"].row<int16_t>(0);
    int compared = 0;
    for (int v = 0; v < config.sim.height; ++v) {
      const int16_t d = tree["truth/disparity"].row<int16_t>(v)[centre];
      if (d < 32 || d >= 16 * 48) continue;
      EXPECT_NEAR(floor[d], v, 1.0) << "slope " << slope;
      ++compared;
    }
    EXPECT_GT(compared, 100);
  }
}

TEST(SimSource, sky_has_no_disparity_and_says_why) {
  Config config;
  config.sim = small("empty");
  config.sim.pitch = 0;
  Tree tree(config);
  tree.step();
  EXPECT_EQ(tree["truth/disparity"].row<int16_t>(5)[100], rejected(Rejected::outside));
  EXPECT_EQ(tree["truth/object"].row<uint8_t>(5)[100], sim::TruthView::sky);
  EXPECT_GT(tree["truth/disparity"].row<int16_t>(200)[100], 0);
}

TEST(SimSource, a_frame_that_takes_long_is_waited_for) {
  Config config;
  config.sim = small("flat");
  const auto source = open_sim(config, {VDISP_SLOW_SIMULATOR});
  const std::vector<ImageSpec> specs = source->open();
  BufferOutlet left(specs[0]), right(specs[1]);
  for (int frame = 0; frame < 2; ++frame) {
    Image* images[] = {Image::make(&left.loan(), specs[0]), Image::make(&right.loan(), specs[1])};
    ASSERT_EQ(source->grab(images), Outcome::valid) << "frame " << frame;
    EXPECT_EQ(images[1]->row<uint8_t>(0)[0], frame + 1);
  }
}

TEST(SimSource, a_missing_renderer_is_said_with_the_places_looked_at) {
  try {
    open_sim(Config{}, {"/nowhere/bin", "/nowhere/lib"});
    FAIL();
  } catch (const SourceError& error) {
    EXPECT_EQ(error.exit_code, 69);
    EXPECT_NE(std::string(error.what()).find("/nowhere/bin, /nowhere/lib"), std::string::npos) << error.what();
  }
}

TEST(SimSource, another_size_than_asked_for_is_refused) {
  Config config;
  config.image_source.width = 1280;
  try {
    open_sim(config);
    FAIL();
  } catch (const SourceError& error) {
    EXPECT_EQ(error.exit_code, 78);
  }
}

}  // namespace
}  // namespace vdisp
