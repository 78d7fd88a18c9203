// plane_floor.cpp: is there anything to see, the plane, the profile, and what is remembered of them.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/plane_floor.h"

#include <algorithm>
#include <cmath>

#include "daemon/stages/local_floor.h"
#include "daemon/stages/projection.h"

namespace vdisp {
namespace {

constexpr int dark = 14, bright = 250;    // grey levels
constexpr double most_bright = 0.7;       // share of the pixels
constexpr double least_matched = 0.01;    // share of the pixels with a disparity
constexpr double most_untextured = 0.97;  // share of the pixels refused for it
constexpr double least_bank = 0.01;       // m per m: 3 cm at the border of a map 5 m wide
constexpr double good_points = 300;       // on the floor, of some 8000 looked at in 640x480
constexpr int trusted_from = 10;          // frames that agreed with [mounting]
constexpr double trusted_s = 30;          // without a floor
constexpr double steady_s = 2;            // time constant of the filtered pose
// rad: how far a floor may be off the last one until that counts half; where an IMU tells how the camera turned since.
constexpr double last_off = 0.15, turned_off = 0.05;

Point normal_of(double pitch, double roll) { return camera({0, 1, 0}, pitch, roll); }

}  // namespace

std::vector<ImageSpec> PlaneFloor::check(std::span<const ImageSpec> in) {
  if (in.size() != 3)
    throw FormatError("takes the disparity, the left view and the IMU, was given " + std::to_string(in.size()) + " images");
  require(in[0], Pixel::disparity16, "the disparity");
  require(in[1], Pixel::gray8, "the left view");
  require(in[2], Pixel::record, "the IMU");
  require_same_size(in[0], in[1]);
  search_.prepare(in[0]);
  profile_.prepare(search_.most_points());
  return {{Pixel::line16, 0, static_cast<uint16_t>(16 * config_.image_source.ndisp), 1}, record_spec<FloorModel>()};
}

void PlaneFloor::begin_anew() noexcept {
  gravity_.forget();
  last_.reset();
  last_ns_ = 0;
  trust_ = {};
}

Outcome PlaneFloor::process(std::span<const Image* const> in, std::span<Image* const> out) noexcept {
  const Image& disparity = *in[0];
  FloorModel& model = make_record<FloorModel>(*out[1]);
  model.model = profiles_ ? FloorKind::profile : FloorKind::plane;
  model.pitch_rad = model.roll_rad = model.height_m = std::nan("");
  model.steady_pitch_rad = model.steady_roll_rad = model.steady_height_m = std::nan("");
  model.gravity_pitch_rad = model.gravity_roll_rad = std::nan("");
  const double mounted = config_.expected_pitch();
  gravity_.take(in[2]->valid() ? record_of<Imu>(*in[2]) : nullptr, std::isnan(mounted) && last_ ? last_->steady_pitch_rad : mounted);
  model.imu = gravity_.use();
  Reason why = blindness(disparity, *in[1]);
  const bool sees = why == Reason::none;
  if (sees && !find(disparity, model)) why = Reason::no_floor;
  if (why != Reason::none && !(sees && hold(disparity, why, model))) {
    model.state = FloorState::lost;
    model.imu = gravity_.use();
    model.reason = out[0]->reason = out[1]->reason = why;
    return Outcome::invalid;
  }
  if (model.state == FloorState::held) {
    for (Image* image : out) image->flags |= flag_held;
  }
  const StereoView view = stereo_view(disparity);
  const LocalFloor floor(model, view);
  const bool metres = view.calibrated();
  int16_t* rows = out[0]->row<int16_t>(0);
  for (int column = 0; column < out[0]->spec.width; ++column) {
    const double d = true_disparity(disparity.camera, column);
    const double row = metres && d > 0 ? floor.row(d) : 16 * model.a * d + model.b;
    rows[column] = static_cast<int16_t>(std::floor(std::clamp(row, -32000.0, 32000.0) + 0.5));
  }
  return Outcome::valid;
}

Reason PlaneFloor::blindness(const Image& disparity, const Image& left) const noexcept {
  constexpr int step = 8;
  size_t all = 0, sum = 0, full = 0, matched = 0, untextured = 0;
  for (int v = step / 2; v < left.spec.height; v += step) {
    const uint8_t* grey = left.row<uint8_t>(v);
    const int16_t* d = disparity.row<int16_t>(v);
    for (int u = v / step % 2 * step / 2; u < left.spec.width; u += step) {
      ++all;
      sum += grey[u];
      full += grey[u] >= bright;
      const uint8_t code = rejected_code(d[u]);
      matched += code == 0;
      untextured += code == static_cast<uint8_t>(Rejected::low_texture);
    }
  }
  const double n = static_cast<double>(all), lit = static_cast<double>(sum) / n;
  if (lit < dark) return Reason::too_dark;
  if (static_cast<double>(full) > most_bright * n) return Reason::too_bright;
  if (static_cast<double>(matched) >= least_matched * n) return Reason::none;
  return static_cast<double>(untextured) > most_untextured * n ? Reason::no_texture : Reason::no_matches;
}

bool PlaneFloor::find(const Image& disparity, FloorModel& model) noexcept {
  const StereoView view = stereo_view(disparity);
  model.points = static_cast<uint32_t>(search_.collect(disparity));
  std::optional<PlaneSearch::Expected> last;
  if (const auto turned = predicted(view)) {
    last = {*turned, turned_off};
  } else if (last_) {
    last = {LocalFloor(*last_, view).plane(), last_off};
  }
  const auto found = search_.search(view, disparity.sequence, last ? &*last : nullptr, trusts_mounting(disparity));
  if (!found || !PlaneSearch::holds(*found)) return false;
  describe(view, *found, model);
  if (profiles_ && view.calibrated()) {
    profile_.measure(search_, disparity, model);
    const double bank = profile_.bank(model);
    FloorPlane plane = found->plane;
    plane.across += bank * view.baseline / model.height_m;
    lay(plane, view, model);
    // Of ground that leaned the profile is that of its low side.
    if (std::abs(bank) > least_bank) profile_.measure(search_, disparity, model);
  }
  steady(disparity, model);
  if (!std::isnan(model.height_m)) gravity_.found(normal_of(model.pitch_rad, model.roll_rad));
  last_ = model;
  last_ns_ = disparity.timestamp_ns;
  if (trust_.frames < trusted_from) trust_.frames = agrees_with_mounting(model) ? trust_.frames + 1 : 0;
  return true;
}

bool PlaneFloor::trusts_mounting(const Image& disparity) noexcept {
  const auto& mounting = config_.mounting;
  const double pitch = config_.expected_pitch();
  const bool changed = mounting.height != trust_.height || pitch != trust_.pitch || mounting.roll != trust_.roll;
  const bool long_lost = last_ && static_cast<double>(disparity.timestamp_ns - last_ns_) > trusted_s * 1e9;
  if (changed || long_lost) trust_ = {mounting.height, pitch, mounting.roll, 0};
  return trust_.frames >= trusted_from;
}

/// False where [mounting] does not tell height and pitch: there is nothing to trust.
bool PlaneFloor::agrees_with_mounting(const FloorModel& model) const noexcept {
  const auto& mounting = config_.mounting;
  return mounting.height > 0 && !std::isnan(config_.expected_pitch()) && !std::isnan(model.height_m) && !model.mounting_differs &&
         std::abs(model.steady_roll_rad - mounting.roll) <= mounting.pitchTolerance;
}

void PlaneFloor::describe(const StereoView& view, const PlaneSearch::Found& found, FloorModel& model) noexcept {
  const double on = found.all.on, beyond = found.feet.beyond;
  model.state = FloorState::found;
  model.points = found.all.on;
  model.confidence = on / (on + 2 * beyond) * std::min(1.0, on / good_points);
  if (!view.calibrated()) model.reason = Reason::no_calibration;
  lay(found.plane, view, model);
}

void PlaneFloor::lay(const FloorPlane& plane, const StereoView& view, FloorModel& model) noexcept {
  model.a = 1 / (16 * plane.down);
  model.b = plane.horizon(view);
  model.tilt = plane.across;
  if (!view.calibrated()) return;
  const PlanePose pose = pose_of(plane, view);
  model.pitch_rad = pose.pitch;
  model.roll_rad = pose.roll;
  model.height_m = pose.height;
}

/// What lasts of pitch, roll and height is compared with [mounting]; what a bump does is not.
void PlaneFloor::steady(const Image& disparity, FloorModel& model) noexcept {
  if (std::isnan(model.height_m)) return;
  double part = 1;
  if (last_ && !std::isnan(last_->steady_height_m) && disparity.timestamp_ns > last_ns_)
    part = 1 - std::exp(-static_cast<double>(disparity.timestamp_ns - last_ns_) * 1e-9 / steady_s);
  const auto follow = [&](double before, double now) { return part >= 1 ? now : before + part * (now - before); };
  const FloorModel& before = last_ ? *last_ : model;
  model.steady_pitch_rad = follow(before.steady_pitch_rad, model.pitch_rad);
  model.steady_roll_rad = follow(before.steady_roll_rad, model.roll_rad);
  model.steady_height_m = follow(before.steady_height_m, model.height_m);
  const auto& mounting = config_.mounting;
  const double expected = config_.expected_pitch();
  const bool height_differs =
      mounting.height > 0 && std::abs(model.steady_height_m - mounting.height) > mounting.heightTolerance * mounting.height;
  const bool pitch_differs = !std::isnan(expected) && std::abs(model.steady_pitch_rad - expected) > mounting.pitchTolerance;
  model.mounting_differs = height_differs || pitch_differs;
  weigh(before, part, model);
}

void PlaneFloor::weigh(const FloorModel& before, double part, FloorModel& model) noexcept {
  const auto down = gravity_.down();
  if (!down) {
    // A rover that accelerates for a moment still stands on the same slope.
    model.gravity_pitch_rad = last_ && model.imu == ImuUse::accelerating ? before.gravity_pitch_rad : std::nan("");
    model.gravity_roll_rad = last_ && model.imu == ImuUse::accelerating ? before.gravity_roll_rad : std::nan("");
    model.gravity_differs = last_ && model.imu == ImuUse::accelerating ? before.gravity_differs : 0;
    return;
  }
  const double pitch = std::atan2(down->z, std::hypot(down->x, down->y)), roll = std::atan2(down->x, down->y);
  const bool anew = !last_ || std::isnan(before.gravity_pitch_rad);
  model.gravity_pitch_rad = anew ? pitch : before.gravity_pitch_rad + part * (pitch - before.gravity_pitch_rad);
  model.gravity_roll_rad = anew ? roll : before.gravity_roll_rad + part * (roll - before.gravity_roll_rad);
  const double most = config_.mounting.pitchTolerance;
  model.gravity_differs =
      std::abs(model.gravity_pitch_rad - model.steady_pitch_rad) > most || std::abs(model.gravity_roll_rad - model.steady_roll_rad) > most;
}

std::optional<FloorPlane> PlaneFloor::predicted(const StereoView& view) const noexcept {
  const auto normal = gravity_.predicted();
  if (!normal || !last_ || std::isnan(last_->height_m)) return std::nullopt;
  return plane_of({std::atan2(normal->z, std::hypot(normal->x, normal->y)), std::atan2(normal->x, normal->y), last_->height_m}, view);
}

bool PlaneFloor::hold(const Image& disparity, Reason why, FloorModel& model) noexcept {
  if (!last_) return false;
  const double age = static_cast<double>(disparity.timestamp_ns - last_ns_) * 1e-9;
  if (!(age >= 0 && age <= config_.floor.hold)) return false;
  model = *last_;
  const StereoView view = stereo_view(disparity);
  if (const auto plane = predicted(view)) lay(*plane, view, model);
  model.imu = gravity_.use();
  model.state = FloorState::held;
  model.reason = why;
  model.held_s = age;
  model.confidence *= 1 - age / (config_.floor.hold + 1e-9);
  return true;
}

}  // namespace vdisp
