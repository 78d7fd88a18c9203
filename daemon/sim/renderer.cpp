// renderer.cpp: one frame: both cameras tile by tile; and the same world once more through the ideal left camera, for the truth.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sim/renderer.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "daemon/sim/lens.h"
#include "daemon/sim/ride.h"
#include "daemon/sim/shade.h"
#include "daemon/sim/shadows.h"
#include "daemon/sim/texture.h"
#include "daemon/sim/tracer.h"

namespace vdisp::sim {
namespace {

void place_object(const Scene& scene, size_t i, ObjectTable& table) {
  const SceneObject& o = scene.objects()[i];
  table.x[i] = static_cast<float>(o.x);
  table.y[i] = static_cast<float>(scene.ground(o.x, o.z));
  table.z[i] = static_cast<float>(o.z);
  table.cos_yaw[i] = static_cast<float>(std::cos(o.yaw));
  table.sin_yaw[i] = static_cast<float>(std::sin(o.yaw));
}

ObjectTable tabulate(const Scene& scene, const sim_section& parameters, uint32_t seed) {
  ObjectTable table;
  for (const SceneObject& o : scene.objects()) {
    const auto index = static_cast<uint32_t>(table.x.size());
    for (auto* column : {&table.x, &table.y, &table.z, &table.cos_yaw, &table.sin_yaw}) column->push_back(0);
    place_object(scene, index, table);
    table.brightness.push_back(static_cast<float>(o.brightness));
    table.contrast.push_back(o.textured ? static_cast<float>(parameters.texture * o.contrast) : 0.0f);
    // Crates and bricks begin at the ground; what has no courses may begin anywhere.
    const bool courses = o.surface == Surface::bricks || o.surface == Surface::planks;
    table.shift.push_back(courses ? 0.0f : static_cast<float>(scramble(seed + index) & 1023) / 300.0f);
    table.texels_per_m.push_back(o.surface == Surface::planks ? 420.0f : 340.0f);
    table.texture.push_back(static_cast<int32_t>(o.surface) * Textures::words);
  }
  return table;
}

class Renderer final : public Simulator {
 public:
  Renderer(const sim_section& parameters, Scene scene, std::unique_ptr<Tracer> tracer)
      : parameters_(parameters),
        seed_(scramble(static_cast<uint32_t>(parameters.seed) + 77)),
        scene_(std::move(scene)),
        tracer_(std::move(tracer)),
        calibration_(make_calibration(parameters)),
        textures_(make_textures(seed_, parameters.floor == "tiles")),
        objects_(tabulate(scene_, parameters, seed_)),
        light_(bake(scene_, *tracer_, textures_, parameters.shadow)),
        shader_(choose_shader()),
        draw_(tracer_->make_probe()),
        measure_(tracer_->make_probe()) {
    const int width = parameters.width, height = parameters.height;
    for (size_t side = 0; side < 2; ++side) rays_[side] = raw_rays((*calibration_.raw)[side], width, height);
    ideal_ = rectified_rays(calibration_.view, width, height);
    marks_.resize(static_cast<size_t>(ideal_.tiles()));
    truth_marks_ = marks_;
    const size_t pixels = static_cast<size_t>(width) * height;
    depth_.resize(pixels);
    elevation_.resize(pixels);
    number_.resize(pixels);
    numbers_.resize(scene_.objects().size());
    truth_.width = width;
    truth_.height = height;
    truth_.depth = depth_;
    truth_.elevation = elevation_;
    truth_.object = number_;
  }

  const Calibration& calibration() const override { return calibration_; }

  void render(uint64_t frame, std::byte* left, std::byte* right, size_t stride) noexcept override {
    const CameraPose pose = scene_.pose(frame);
    for (uint32_t side = 0; side < 2; ++side) {
      Look look = looking(pose, side == 0 ? 0 : calibration_.view.baseline);
      look.gain = static_cast<float>(side == 0 ? parameters_.light : parameters_.light * parameters_.gain);
      apply_event(frame, look);
      look.noise_seed = scramble(static_cast<uint32_t>(frame) * 2 + side + scramble(seed_ + static_cast<uint32_t>(frame >> 31)));
      draw(look, rays_[side], reinterpret_cast<uint8_t*>(side == 0 ? left : right), stride);
    }
  }

  Odometry rover(uint64_t frame) const noexcept override { return scene_.rover(frame); }
  Imu imu(uint64_t frame) const noexcept override { return scene_.imu(frame); }

  const TruthView& truth(uint64_t frame) noexcept override {
    if (frame != truth_frame_) measure(frame);
    truth_frame_ = frame;
    return truth_;
  }

  const RobotReport* robot() const noexcept override { return scene_.ride() ? &scene_.ride()->report() : nullptr; }

  void step(const Order& order) noexcept override {
    scene_.step(order);
    tracer_->move(scene_);
    for (size_t i = scene_.first_moving(); i < scene_.objects().size(); ++i) place_object(scene_, i, objects_);
    truth_frame_ = UINT64_MAX;
  }

  std::vector<WorldOutline> outlines() const override {
    std::vector<WorldOutline> outlines;
    if (!scene_.ride()) return outlines;
    const FloorPlan& plan = scene_.ride()->plan();
    for (size_t i = 0; i < plan.first_person(); ++i) {
      outlines.push_back({plan.things()[i].what, {}});
      for (const Spot& corner : plan.things()[i].outline) outlines.back().corners.push_back({corner.z, -corner.x});
    }
    return outlines;
  }

  Place place(double x, double z) const noexcept override { return scene_.place(pose_, x, z); }

  double ground_row(double depth) const noexcept override {
    return calibration_.view.cy + calibration_.view.f * scene_.ground_below(pose_, depth) / depth;
  }

 private:
  Look looking(const CameraPose& pose, double offset) const {
    Look look{};
    for (size_t i = 0; i < 9; ++i) look.axes[i] = static_cast<float>(pose.axes[i]);
    look.x = static_cast<float>(pose.position.x + pose.axes[0] * offset);
    look.y = static_cast<float>(pose.position.y + pose.axes[3] * offset);
    look.z = static_cast<float>(pose.position.z + pose.axes[6] * offset);
    look.rise = static_cast<float>(scene_.terrain().rise());
    look.slope_start = scene_.terrain().rise() != 0 ? static_cast<float>(Ground::slope_start) : far_away;
    look.meshed = scene_.terrain().meshed();
    look.pixel = static_cast<float>(1 / calibration_.view.f);
    if (parameters_.floor == "tiles") look.coarse = 0;
    look.sun_x = static_cast<float>(scene_.to_light().x);
    look.sun_y = static_cast<float>(scene_.to_light().y);
    look.sun_z = static_cast<float>(scene_.to_light().z);
    look.ground = static_cast<float>(scene_.ground_brightness());
    look.contrast = static_cast<float>(parameters_.texture);
    look.noise = static_cast<float>(parameters_.noise);
    look.texels = textures_.texels.data();
    look.objects = &objects_;
    look.light = &light_;
    return look;
  }

  void apply_event(uint64_t frame, Look& look) const {
    look.covered = -1;
    const std::string& event = parameters_.event;
    if (event == "none" || frame < static_cast<uint64_t>(parameters_.eventFrame)) return;
    if (event == "cap") look.covered = 0;
    if (event == "blank") look.covered = 150;
    if (event == "dark") look.gain *= 0.02f;
    if (event == "bright") look.gain *= 40;
  }

  void draw(const Look& look, const Rays& rays, uint8_t* image, size_t stride) noexcept {
    tracer_->mark(look, rays, marks_);
    for (int tile = 0; tile < rays.tiles(); ++tile) {
      const size_t first = static_cast<size_t>(tile) * Rays::tile_pixels;
      const int u = tile % rays.tiles_x * Rays::tile_width, v = tile / rays.tiles_x * Rays::tile_height;
      const uint8_t mark = marks_[static_cast<size_t>(tile)];
      const bool objects = mark != 0;
      shader_.aim(look, &rays.x[first], &rays.y[first], batch_);
      if (objects) tracer_->trace(*draw_, look, mark, batch_);
      shader_.colour(look, objects, batch_);
      if (look.covered >= 0) std::fill(std::begin(batch_.gray), std::end(batch_.gray), look.covered);
      alignas(64) uint8_t pixels[Rays::tile_pixels];
      shader_.expose(look, batch_, static_cast<uint32_t>(v) * 2048 + static_cast<uint32_t>(u), 2048, pixels);
      const int columns = std::min(Rays::tile_width, rays.width - u), rows = std::min(Rays::tile_height, rays.height - v);
      for (int y = 0; y < rows; ++y)
        std::memcpy(image + static_cast<size_t>(v + y) * stride + u, pixels + y * Rays::tile_width, static_cast<size_t>(columns));
    }
  }

  void measure(uint64_t frame) noexcept {
    const CameraPose pose = pose_ = scene_.pose(frame);
    const Look look = looking(pose, 0);
    scene_.describe(pose, truth_, numbers_);
    tracer_->mark(look, ideal_, truth_marks_);
    for (int tile = 0; tile < ideal_.tiles(); ++tile) {
      const size_t first = static_cast<size_t>(tile) * Rays::tile_pixels;
      shader_.aim(look, &ideal_.x[first], &ideal_.y[first], truth_batch_);
      const uint8_t mark = truth_marks_[static_cast<size_t>(tile)];
      if (mark) tracer_->trace(*measure_, look, mark, truth_batch_);
      for (int i = 0; i < Rays::tile_pixels; ++i) {
        const int u = tile % ideal_.tiles_x * Rays::tile_width + i % Rays::tile_width,
                  v = tile / ideal_.tiles_x * Rays::tile_height + i / Rays::tile_width;
        if (u < ideal_.width && v < ideal_.height) note(pose, truth_batch_, i, static_cast<size_t>(v) * ideal_.width + u);
      }
    }
  }

  void note(const CameraPose& pose, const Batch& batch, int i, size_t pixel) noexcept {
    const bool sky = batch.t[i] >= far_away;
    const int object = batch.object[i];
    depth_[pixel] = sky ? 0 : batch.t[i];
    number_[pixel] = sky ? TruthView::sky : object < 0 ? TruthView::ground : numbers_[static_cast<size_t>(object)];
    elevation_[pixel] = 0;
    if (sky || object < 0) return;
    const double t = batch.t[i], x = pose.position.x + t * batch.dx[i], z = pose.position.z + t * batch.dz[i];
    elevation_[pixel] = static_cast<float>(scene_.ground(x, z) - (pose.position.y + t * batch.dy[i]));
  }

  sim_section parameters_;
  uint32_t seed_;
  Scene scene_;
  std::unique_ptr<Tracer> tracer_;
  Calibration calibration_;
  Textures textures_;
  ObjectTable objects_;
  GroundLight light_;
  Shader shader_;
  std::array<Rays, 2> rays_;
  Rays ideal_;
  // render() and truth() run beside each other: each has memory of its own.
  std::unique_ptr<Tracer::Probe, Tracer::EraseProbe> draw_, measure_;
  std::vector<uint8_t> marks_, truth_marks_;
  Batch batch_{}, truth_batch_{};
  uint64_t truth_frame_ = UINT64_MAX;
  CameraPose pose_{};  ///< of truth_frame_
  TruthView truth_;
  std::vector<float> depth_, elevation_;
  std::vector<uint8_t> number_, numbers_;
};

}  // namespace

std::unique_ptr<Simulator> make_simulator(const sim_section& parameters) {
  Scene scene(parameters);
  auto tracer = Tracer::make(scene, static_cast<uint32_t>(parameters.seed));
  return tracer ? std::make_unique<Renderer>(parameters, std::move(scene), std::move(tracer)) : nullptr;
}

}  // namespace vdisp::sim
