// sim.cpp: loads the renderer, and draws the next frame while the tree works on this one.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sources/sim.h"

#include <dlfcn.h>

#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>

#include "daemon/sim/simulator.h"
#include "daemon/sim/truth.h"
#include "daemon/sources/robot_track.h"

namespace vdisp {
namespace {

constexpr const char* module_name = "vdisp_sim.so";
// Not the 100 ms of a camera: the simulator is lock-step, and a blind frame on a slow machine would make results depend on its
// speed. Drawing is arithmetic that ends; only a machine that stands still takes longer than this.
constexpr std::chrono::seconds longest_wait{20};

class SimSource final : public StereoSource {
 public:
  SimSource(const Config& config, std::unique_ptr<sim::Simulator> simulator)
      : config_(config),
        spec_{Pixel::gray8, 0, static_cast<uint16_t>(config.sim.width), static_cast<uint16_t>(config.sim.height)},
        simulator_(std::move(simulator)),
        robot_(simulator_->robot()) {
    if (!config.sim.track.empty()) track_.emplace(config.sim.track, simulator_->outlines());
  }
  ~SimSource() override {
    {
      const std::lock_guard lock(mutex_);
      ending_ = true;
    }
    changed_.notify_all();
    if (painter_.joinable()) painter_.join();
  }

  std::vector<ImageSpec> open() override {
    for (auto& view : drawn_) view.resize(static_cast<size_t>(spec_.stride()) * spec_.height);
    if (!painter_.joinable()) painter_ = std::thread([this] { paint(); });
    return {spec_, spec_};
  }
  std::vector<ImageSpec> heeds() const override {
    if (robot_ && config_.sim.drive == "command") return {record_spec<DriveCommand>()};
    return {};
  }
  void heed(std::span<const Image* const> last) noexcept override {
    const DriveCommand* command = last[0]->valid() ? record_of<DriveCommand>(*last[0]) : nullptr;
    order_ = command ? sim::Order{false, command->speed, command->turn_rate} : sim::Order{};
    ordered_ = command ? command->steering : Steering::forward;
  }

  Outcome grab(std::span<Image* const> out) noexcept override {
    std::unique_lock lock(mutex_);
    for (Image* image : out) {
      image->timestamp_ns = static_cast<int64_t>(frame_) * sim::frame_period_ns(config_.sim);
      image->flags |= flag_synthetic;
      image->calibration_hash = simulator_->calibration().hash;
    }
    if (robot_ && !asked_) {
      // A world goes on when the last frame has been worked on, not beside it.
      if (frame_ > 0) simulator_->step(order_);
      asked_ = true;
      changed_.notify_all();
    }
    if (!changed_.wait_for(lock, longest_wait, [&] { return ready_; })) {
      for (Image* image : out) image->set_blind(Reason::no_frame);
      return Outcome::invalid;
    }
    if (config_.sim.odometry) pose_ = rover_pose();
    if (config_.sim.imu) {
      imu_ = simulator_->imu(frame_);
      imu_.timestamp_ns = static_cast<int64_t>(frame_) * sim::frame_period_ns(config_.sim);
    }
    for (size_t side = 0; side < 2; ++side) std::memcpy(out[side]->row<std::byte>(0), drawn_[side].data(), drawn_[side].size());
    ++frame_;
    ready_ = asked_ = false;
    lock.unlock();
    if (!robot_) changed_.notify_all();
    return Outcome::valid;
  }

  std::optional<Calibration> calibration() const override { return simulator_->calibration(); }
  int64_t period_ns() const override { return config_.sim.rate > 0 ? sim::frame_period_ns(config_.sim) : 0; }
  const Odometry* odometry() const noexcept override { return config_.sim.odometry ? &pose_ : nullptr; }
  const Imu* imu() const noexcept override { return config_.sim.imu ? &imu_ : nullptr; }
  bool news(std::string& line) override {
    if (track_ && track_->failed() && !told_failure_) {
      line = "sim: " + config_.sim.track + "/track.csv cannot be written: it ends early";
      return told_failure_ = true;
    }
    if (!robot_ || (robot_->collisions == told_collisions_ && robot_->stuck_times == told_stuck_)) return false;
    const bool collision = robot_->collisions != told_collisions_;
    char text[160];
    std::snprintf(text, sizeof text, "sim: %s %llu%s%s at x %.2f m, y %.2f m after %.1f m", collision ? "collision" : "stuck",
                  static_cast<unsigned long long>(collision ? ++told_collisions_ : ++told_stuck_), collision ? " with a " : "",
                  collision ? robot_->met : "", robot_->x, robot_->y, robot_->travelled);
    line = text;
    return true;
  }
  bool bumped() noexcept override { return robot_ && robot_->collisions != std::exchange(bumps_, robot_->collisions); }
  void add_truth(Driver& driver, Handle camera) override { sim::add_truth_stages(driver, camera, *simulator_, config_); }

 private:
  /// The scene's place is below the camera; [mounting] says where in the rover that is.
  Odometry rover_pose() const noexcept {
    Odometry pose = simulator_->rover(frame_);
    const mounting_section& mounting = config_.mounting;
    pose.x -= std::cos(pose.yaw) * mounting.x - std::sin(pose.yaw) * mounting.y;
    pose.y -= std::sin(pose.yaw) * mounting.x + std::cos(pose.yaw) * mounting.y;
    pose.timestamp_ns = static_cast<int64_t>(frame_) * sim::frame_period_ns(config_.sim);
    pose.speed = pose.turn_rate = std::nan("");
    pose.position_deviation = pose.yaw_deviation = 0;
    return pose;
  }

  void paint() noexcept {
    std::unique_lock lock(mutex_);
    while (true) {
      changed_.wait(lock, [&] { return ending_ || (!ready_ && (asked_ || !robot_)); });
      if (ending_) return;
      const uint64_t frame = frame_;
      const sim::RobotReport report = robot_ ? *robot_ : sim::RobotReport{};
      const bool commanded = config_.sim.drive == "command";
      const std::string_view ordered = commanded && order_.brake ? "blind" : name(commanded ? ordered_ : report.steering);
      lock.unlock();
      if (track_) track_->add(static_cast<double>(frame) * static_cast<double>(sim::frame_period_ns(config_.sim)) * 1e-9, report, ordered);
      simulator_->render(frame, drawn_[0].data(), drawn_[1].data(), spec_.stride());
      lock.lock();
      ready_ = true;
      changed_.notify_all();
    }
  }

  const Config& config_;
  const ImageSpec spec_;
  std::unique_ptr<sim::Simulator> simulator_;
  std::mutex mutex_;
  std::condition_variable changed_;
  const sim::RobotReport* robot_;  // null where the scene is no world
  std::optional<RobotTrack> track_;
  sim::Order order_{};  // of the last frame
  Steering ordered_ = Steering::forward;
  uint64_t told_collisions_ = 0, told_stuck_ = 0, bumps_ = 0;
  bool told_failure_ = false;
  // While ready_ the views belong to grab(), else to the painter; a world's painter waits until it is asked.
  bool ready_ = false, asked_ = false, ending_ = false;
  uint64_t frame_ = 0;
  Odometry pose_{};  // of the last frame
  Imu imu_{};        // likewise
  std::array<std::vector<std::byte>, 2> drawn_;
  std::thread painter_;
};

void require_size(const Config& config) {
  const auto refuse = [](const char* key, int wanted, int found) {
    throw SourceError(78, "[image source] " + std::string(key) + " = " + std::to_string(wanted) + ", but [sim] " + key + " = " +
                              std::to_string(found) + "; they must be equal, or the first 0");
  };
  const image_source_section& wanted = config.image_source;
  if (wanted.width != 0 && wanted.width != config.sim.width) refuse("width", wanted.width, config.sim.width);
  if (wanted.height != 0 && wanted.height != config.sim.height) refuse("height", wanted.height, config.sim.height);
}

/// What only worlds have, and what they have not.
void require_world(const sim_section& sim) {
  const auto refuse = [&](const std::string& what, const char* right) {
    throw SourceError(78, "[sim] " + what + " with scene = " + sim.scene + "; " + right);
  };
  if (sim::is_world(sim.scene)) {
    if (sim.ground != "slope" || sim.slope != 0)
      refuse("ground = " + sim.ground + " and a slope", "the ground of office, garage and rocks is level: ground = slope, slope = 0");
    return;
  }
  if (sim.drive != "scene")
    refuse("drive = " + sim.drive, "only office, garage and rocks have a robot to drive; use one of them, or drive = scene");
  if (!sim.track.empty()) refuse("track = " + sim.track, "only office, garage and rocks have a robot; use one of them, or leave track out");
}

/// A rover that drives round would fall in.
void require_way(const sim_section& sim) {
  if (sim.scene == "drive" && (sim.ground == "kerb" || sim.ground == "ditch"))
    throw SourceError(78,
                      "[sim] ground = " + sim.ground + " with scene = drive: the rover's way leads across it; use another scene, or ramp");
}

}  // namespace

std::vector<std::filesystem::path> simulator_places() {
  std::vector<std::filesystem::path> places;
  std::error_code error;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
  if (!error) places = {program.parent_path(), program.parent_path().parent_path() / "lib/vdisp"};
  places.push_back(VDISP_MODULE_DIR);
  return places;
}

std::unique_ptr<StereoSource> open_sim(const Config& config, const std::vector<std::filesystem::path>& places) {
  require_size(config);
  require_world(config.sim);
  require_way(config.sim);
  std::string looked;
  for (const std::filesystem::path& place : places) {
    const std::filesystem::path file = place / module_name;
    looked += (looked.empty() ? "" : ", ") + place.string();
    std::error_code error;
    if (!std::filesystem::exists(file, error)) continue;
    // Never closed: the ray tracer leaves threads behind that run its code.
    void* module = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!module) throw SourceError(69, "sim: the renderer " + file.string() + " does not load: " + dlerror());
    auto* make = reinterpret_cast<sim::MakeSimulator*>(dlsym(module, sim::make_simulator_symbol));
    if (!make) throw SourceError(69, "sim: " + file.string() + " is no renderer of this version: it lacks " + sim::make_simulator_symbol);
    std::unique_ptr<sim::Simulator> simulator(make(config.sim));
    if (!simulator)
      throw SourceError(69, "sim: the renderer " + file.string() + " cannot start: no memory, or Embree refused this processor");
    return std::make_unique<SimSource>(config, std::move(simulator));
  }
  throw SourceError(
      69, "sim: the renderer " + std::string(module_name) + " was not found in " + looked + "; it comes with the simulator's package");
}

}  // namespace vdisp
