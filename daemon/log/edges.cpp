// edges.cpp: "floor lost", "floor found after 1.2 s".
// SPDX-License-Identifier: Apache-2.0
#include "daemon/log/edges.h"

#include <cmath>

#include "daemon/log/log.h"

namespace vdisp::log {
namespace {

constexpr int64_t second = 1'000'000'000;
constexpr int lasting_frames = 15;  // a single odd floor is no reason to doubt the mounting

}  // namespace

void Edges::edge(Subject& subject, const char* what, std::string_view fault, const Image& image) {
  if (subject.lost != !image.valid()) {
    subject.lost = !image.valid();
    (subject.lost ? subject.since_ns : subject.found_ns) = image.ready_ns;
    ++subject.untold;
  }
  if (subject.lost == subject.told_lost || image.ready_ns - subject.told_ns < second) return;
  if (subject.lost) {
    const std::string_view why = fault.empty() ? describe(image.reason) : fault;
    if (subject.untold > 1) {
      warn("{} lost at frame {}: {} (lost and found {} times since the last message)", what, image.sequence, why, subject.untold / 2);
    } else {
      warn("{} lost at frame {}: {}", what, image.sequence, why);
    }
  } else {
    info("{} found after {:.1f} s, at frame {}", what, static_cast<double>(subject.found_ns - subject.since_ns) * 1e-9, image.sequence);
  }
  subject.told_lost = subject.lost;
  subject.told_ns = image.ready_ns;
  subject.untold = 0;
}

void Edges::compare(const FloorModel& model, const Image& image) {
  const bool differs = model.mounting_differs != 0;
  frames_otherwise_ = differs == differs_ ? 0 : frames_otherwise_ + 1;
  if (frames_otherwise_ < lasting_frames) return;
  differs_ = differs;
  const bool filtered = !std::isnan(model.steady_height_m);
  warn("the floor {}: measured height {:.2f} m and pitch {:.3f} rad, configured {:.2f} m and {:.3f} rad (frame {})",
       differs ? "does not agree with [mounting]" : "agrees with [mounting] again", filtered ? model.steady_height_m : model.height_m,
       filtered ? model.steady_pitch_rad : model.pitch_rad, config_.mounting.height, config_.expected_pitch(), image.sequence);
}

void Edges::weigh(const FloorModel& model, const Image& image) {
  const bool differs = model.gravity_differs != 0;
  weighed_otherwise_ = differs == askew_ ? 0 : weighed_otherwise_ + 1;
  if (weighed_otherwise_ >= lasting_frames) {
    askew_ = differs;
    warn("gravity {} (frame {}): over the floor the camera has pitch {:.3f} and roll {:.3f} rad, by the IMU {:.3f} and {:.3f} rad",
         differs ? "differs from the floor, by a slope, or [mounting] or the IMU is askew" : "and floor agree again", image.sequence,
         model.steady_pitch_rad, model.steady_roll_rad, model.gravity_pitch_rad, model.gravity_roll_rad);
  }
}

/// Accelerating, late and the first sample are no faults.
void Edges::judge_imu(const FloorModel& model, const Image& image) {
  const bool fault = model.imu == ImuUse::jumped || model.imu == ImuUse::askew || model.imu == ImuUse::contradicts;
  if ((!fault && model.imu != ImuUse::used) || fault == imu_ignored_ || image.ready_ns - imu_told_ns_ < second) return;
  imu_ignored_ = fault;
  imu_told_ns_ = image.ready_ns;
  if (fault) {
    warn("IMU ignored from frame {} on: {}", image.sequence, describe(model.imu));
  } else {
    info("IMU believed again from frame {} on", image.sequence);
  }
}

void Edges::say_what_is_near(const FloorModel& model, const CameraGeometry& camera) {
  const double below = std::atan((rows_ - static_cast<double>(camera.cy)) / static_cast<double>(camera.f));
  const double depth =
      static_cast<double>(camera.f * camera.baseline) / (camera.min_disparity + camera.disparities - static_cast<double>(camera.cx_offset));
  debug("the floor is in view from {:.2f} m ahead; what is nearer than {:.2f} m along the view is not seen (ndisp)",
        model.height_m / std::tan(model.pitch_rad + below), depth);
}

/// Lost is said of what came once: most rovers have not all of it. Events come when they like.
void Edges::incoming(Incoming& kind, const char* what, const InputTally& tally, const Image& image) {
  if (tally.accepted > 0 && &kind != &event_) edge(kind.subject, what, {}, image);
  if (tally.refused != kind.refused) {
    if (!kind.refusing) warn("{} refused at frame {}: {}", what, image.sequence, describe(tally.last_refusal));
    if (!kind.refusing) kind.refused_before = kind.refused;
    kind.refusing = true;
    kind.refused = tally.refused;
    kind.refused_ns = image.ready_ns;
  } else if (kind.refusing && image.ready_ns - kind.refused_ns > second) {
    kind.refusing = false;
    info("{} refused no more, after {} messages, the last one: {}", what, kind.refused - kind.refused_before, describe(tally.last_refusal));
  }
}

/// Of a rover that never has odometry nothing is said. What is forgotten again and again is said once, and once that it lasts again.
void Edges::remember(const Memory& memory, const Image& image) {
  const bool fused = memory.state == MemoryState::fused;
  if (memory.forgotten != forgotten_) {
    if (!forgetting_ && fused && fused_) warn("memory begun anew at frame {}: {}", image.sequence, describe(memory.cause));
    if (!forgetting_) forgotten_before_ = forgotten_;
    forgetting_ = true;
    forgotten_ = memory.forgotten;
    forgotten_ns_ = image.ready_ns;
  } else if (forgetting_ && image.ready_ns - forgotten_ns_ > 2 * second) {
    forgetting_ = false;
    if (forgotten_ - forgotten_before_ > 1) info("memory lasts again, after it was begun anew {} times", forgotten_ - forgotten_before_);
  }
  if (fused == fused_ || image.ready_ns - memory_told_ns_ < second) return;
  if (fused)
    info("memory at frame {}: the map is fused in the odometry frame", image.sequence);
  else
    warn("memory lost at frame {}: {}; the map is of the frame alone", image.sequence, describe(memory.cause));
  fused_ = fused;
  memory_told_ns_ = image.ready_ns;
}

void Edges::watch_calibration(const CalibrationWatch& watch, const Image& image) {
  const bool drifted = watch.state == CalibrationState::drifted;
  if (drifted == drifted_ || (!drifted && watch.state != CalibrationState::good) || image.ready_ns - drift_told_ns_ < second) return;
  drifted_ = drifted;
  drift_told_ns_ = image.ready_ns;
  constexpr double degrees = 180 / M_PI;
  if (drifted)
    warn(
        "the calibration has drifted (frame {}): rows of {} points differ by {:.2f} px (median), limit {:.2f}; the right view is {:.2f} px "
        "too {} and "
        "turned by {:.2f} deg; vdisp-calibrate check tells what to do",
        image.sequence, watch.points, watch.median_px, watch.limit_px, std::abs(watch.shift_px), watch.shift_px > 0 ? "low" : "high",
        watch.rotation_rad * degrees);
  else
    info("the calibration holds again (frame {}): rows of {} points differ by {:.2f} px (median)", image.sequence, watch.points,
         watch.median_px);
}

void Edges::see(const Topic& topic, const Image& image) {
  if (const Odometry* odometry = record_of<Odometry>(image)) return incoming(odometry_, "odometry", odometry->tally, image);
  if (const Imu* imu = record_of<Imu>(image)) return incoming(imu_, "IMU", imu->tally, image);
  if (const DriveOrder* drive = record_of<DriveOrder>(image)) return incoming(drive_, "drive", drive->tally, image);
  if (const Events* events = record_of<Events>(image)) return incoming(event_, "event", events->tally, image);
  if (const Memory* memory = record_of<Memory>(image); memory && image.valid()) return remember(*memory, image);
  if (const CalibrationWatch* watch = record_of<CalibrationWatch>(image); watch && image.valid()) return watch_calibration(*watch, image);
  if (topic.name == "camera/left") {
    edge(camera_, "frames", fault_(), image);
    if (!told_near_) rows_ = image.spec.height;
  }
  if (topic.name != "floor_model" || camera_.lost) return;
  edge(floor_, "floor", {}, image);
  const FloorModel* model = record_of<FloorModel>(image);
  if (model) judge_imu(*model, image);
  if (!model || !image.valid()) return;
  trace("frame {}: floor height {:.3f} m, pitch {:.4f} rad, confidence {:.2f}", image.sequence, model->height_m, model->pitch_rad,
        model->confidence);
  compare(*model, image);
  if (!std::isnan(model->gravity_pitch_rad)) weigh(*model, image);
  if (told_near_ || std::isnan(model->height_m)) return;
  told_near_ = true;
  say_what_is_near(*model, image.camera);
}

}  // namespace vdisp::log
