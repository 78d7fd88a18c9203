// gravity.cpp: attitude followed from sample to sample.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/gravity.h"

#include <cmath>

namespace vdisp {
namespace {

constexpr double late_s = 0.1;                // of a sample: at 5 degrees and 2 Hz that is up to 6 degrees
constexpr double g = 9.81, g_off = 0.06 * g;  // m/s^2: more and the rover accelerates
constexpr double most_tilt = 0.7;             // rad: a rover that leans more does not drive
constexpr double fastest = 3, noise = 0.03;   // rad/s and rad: what a rover tilts from sample to sample
constexpr double correct_s = 1;               // the accelerometer corrects what rates add up to
constexpr double begin_anew_s = 0.5;          // after a pause, or a jump that lasts
constexpr double fade = 0.97;                 // a frame: predictions are judged over some thirty
constexpr double enough = 0.012;              // rad^2 over these: 0.02 rad a frame

double dot(const Point& a, const Point& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Point cross(const Point& a, const Point& b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
Point unit(const Point& p) {
  const double size = std::sqrt(dot(p, p));
  return {p.x / size, p.y / size, p.z / size};
}
double angle(const Point& a, const Point& b) { return std::atan2(std::sqrt(dot(cross(a, b), cross(a, b))), dot(a, b)); }
double square_off(const Point& a, const Point& b) { return 2 - 2 * dot(a, b); }

/// `p` turned about `axis` by its length, rad; Rodrigues.
Point turned(const Point& p, const Point& axis) {
  const double by = std::sqrt(dot(axis, axis));
  if (by < 1e-12) return p;
  const Point k{axis.x / by, axis.y / by, axis.z / by}, across = cross(k, p);
  const double s = std::sin(by), c = std::cos(by), along = dot(k, p) * (1 - c);
  return {p.x * c + across.x * s + k.x * along, p.y * c + across.y * s + k.y * along, p.z * c + across.z * s + k.z * along};
}

/// The turn, as an axis, that takes a to b the shortest way.
Point shortest_turn(const Point& a, const Point& b) {
  const Point axis = cross(a, b);
  const double size = std::sqrt(dot(axis, axis)), by = size < 1e-12 ? 0 : angle(a, b) / size;
  return {axis.x * by, axis.y * by, axis.z * by};
}

}  // namespace

void Gravity::take(const Imu* imu, double pitch) noexcept {
  if (!imu) {
    use_ = ImuUse::none;
    return;
  }
  use_ = std::isnan(pitch) ? ImuUse::settling : judge(*imu, pitch);
  if (use_ == ImuUse::used && contradicts_) use_ = ImuUse::contradicts;
}

ImuUse Gravity::judge(const Imu& imu, double pitch) noexcept {
  if (!(imu.age_s >= 0 - late_s && imu.age_s <= late_s)) return ImuUse::late;
  if (imu.timestamp_ns == newest_ns_ && down_) return ImuUse::used;
  const auto& [roll, yaw] = std::pair{static_cast<double>(config_.mounting.roll), static_cast<double>(config_.mounting.yaw)};
  // Rover frame (x ahead, y left, z up) to camera frame, by [mounting].
  const auto to_camera = [&](const double(&r)[3]) {
    return camera({r[0] * std::sin(yaw) - r[1] * std::cos(yaw), -r[2], r[0] * std::cos(yaw) + r[1] * std::sin(yaw)}, pitch, roll);
  };
  const double size = std::hypot(imu.acceleration[0], imu.acceleration[1], imu.acceleration[2]);
  if (!(size > 0)) return ImuUse::accelerating;
  const Point up = to_camera(imu.acceleration), measured{-up.x / size, -up.y / size, -up.z / size};
  const double seconds = static_cast<double>(imu.timestamp_ns - newest_ns_) * 1e-9;
  const bool turns = !std::isnan(imu.rate[0]) && !std::isnan(imu.rate[1]);
  const double rates[3] = {turns ? imu.rate[0] : 0, turns ? imu.rate[1] : 0, std::isnan(imu.rate[2]) ? 0 : imu.rate[2]};
  const Point before = rate_;
  rate_ = to_camera(rates);
  if (std::acos(std::min(1.0, imu.acceleration[2] / size)) > most_tilt) {
    down_.reset();
    return ImuUse::askew;
  }
  const bool steady = std::abs(size - g) <= g_off;
  if (!down_ || seconds <= 0 || seconds > begin_anew_s) {
    if (!steady) return ImuUse::accelerating;
    newest_ns_ = imu.timestamp_ns;
    begin(measured);
    return ImuUse::settling;
  }
  // What stands still in the world turns against the rover's turn. Without rates of roll and pitch only about the vertical, if at all.
  const Point against{-seconds * (before.x + rate_.x) / 2, -seconds * (before.y + rate_.y) / 2, -seconds * (before.z + rate_.z) / 2};
  const Point followed = turned(*down_, against);
  const double off = angle(followed, measured);
  if (steady && off > fastest * std::min(seconds, late_s) + noise) return ImuUse::jumped;
  if (!turns && !steady) return ImuUse::accelerating;
  newest_ns_ = imu.timestamp_ns;
  const double part = turns ? (steady ? 1 - std::exp(-seconds / correct_s) : 0) : 1;
  Point correction = shortest_turn(followed, measured);
  correction = {part * correction.x, part * correction.y, part * correction.z};
  down_ = unit(turned(followed, correction));
  // The correction of what rates drifted is no turn of the camera.
  if (turned_) turned_ = turns ? turned(*turned_, against) : turned(turned(*turned_, against), correction);
  return ImuUse::used;
}

void Gravity::forget() noexcept {
  use_ = ImuUse::none;
  contradicts_ = false;
  newest_ns_ = 0;
  down_ = last_ = turned_ = std::nullopt;
  rate_ = {};
  off_predicted_ = off_still_ = 0;
}

void Gravity::begin(const Point& down) noexcept {
  down_ = down;
  turned_.reset();
}

std::optional<Point> Gravity::down() const { return use_ == ImuUse::used ? down_ : std::nullopt; }
std::optional<Point> Gravity::predicted() const { return use_ == ImuUse::used ? turned_ : std::nullopt; }

void Gravity::found(const Point& normal) noexcept {
  const bool follows = use_ == ImuUse::used || use_ == ImuUse::contradicts;
  if (follows && turned_ && last_) compare(normal);
  last_ = normal;
  if (use_ != ImuUse::none && down_) turned_ = normal;
}

void Gravity::compare(const Point& normal) noexcept {
  off_predicted_ = fade * off_predicted_ + square_off(normal, *turned_);
  off_still_ = fade * off_still_ + square_off(normal, *last_);
  if (off_predicted_ > 2 * off_still_ + enough) contradicts_ = true;
  if (off_predicted_ < off_still_ + enough / 2) contradicts_ = false;
}

}  // namespace vdisp
