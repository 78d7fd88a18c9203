// inputs.cpp: what is believed of what comes in, and what is published of it.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/control/inputs.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace vdisp {
namespace {

constexpr int64_t ahead_ns = 50'000'000;  // clocks of one machine agree; a sender may predict a little
constexpr int64_t lasting_ns = 500'000'000;
constexpr double farthest_place = 1e5;                       // m: the headers of grids hold floats, a centimetre there
constexpr double farthest = 1e7, fastest = 1e3;              // m, m/s or rad/s: more is a broken sender
constexpr double free_fall = 4.9, twice_gravity = 2 * 9.81;  // m/s^2: outside, the direction is not gravity's

bool number(double value, double most) { return std::isfinite(value) && std::abs(value) <= most; }
/// NaN is allowed: not known.
bool number_or_none(double value, double most) { return std::isnan(value) || number(value, most); }

Refusal sound(const OdometryMessage& m) {
  for (const double value : {m.x, m.y, m.yaw})
    if (!std::isfinite(value)) return Refusal::not_finite;
  const bool place = number(m.x, farthest_place) && number(m.y, farthest_place) && number(m.yaw, farthest) && number_or_none(m.z, farthest);
  const bool turned = number_or_none(m.roll, M_PI) && number_or_none(m.pitch, M_PI);
  const bool motion = number_or_none(m.speed, fastest) && number_or_none(m.turn_rate, fastest);
  const auto deviation = [](double value) { return std::isnan(value) || (value >= 0 && value <= farthest); };
  return place && turned && motion && deviation(m.position_deviation) && deviation(m.yaw_deviation) ? Refusal::none : Refusal::out_of_range;
}

Refusal sound(const ImuMessage& m) {
  for (const double value : m.acceleration)
    if (!std::isfinite(value)) return Refusal::not_finite;
  const double size = std::hypot(m.acceleration[0], m.acceleration[1], m.acceleration[2]);
  const bool turning = number_or_none(m.rate[0], fastest) && number_or_none(m.rate[1], fastest) && number_or_none(m.rate[2], fastest);
  return size >= free_fall && size <= twice_gravity && turning ? Refusal::none : Refusal::out_of_range;
}

Refusal sound(const DriveMessage& m) {
  if (!std::isfinite(m.speed) || !std::isfinite(m.turn_rate)) return Refusal::not_finite;
  return number(m.speed, fastest) && number(m.turn_rate, fastest) ? Refusal::none : Refusal::out_of_range;
}

Refusal sound(const EventMessage& m) {
  const char* end = static_cast<const char*>(std::memchr(m.label, 0, sizeof m.label));
  const bool printable = end && end != m.label && std::all_of(m.label, end, [](char c) { return c >= ' ' && c <= '~'; });
  return printable ? Refusal::none : Refusal::out_of_range;
}

double seconds(int64_t ns) { return static_cast<double>(ns) * 1e-9; }

}  // namespace

Refusal Inputs::judge(Input& input, int64_t timestamp_ns, uint64_t sender, int64_t now_ns, bool in_order) const {
  const auto age_ns = static_cast<int64_t>(config_.control.maxAge * 1e9);
  if (timestamp_ns > now_ns + ahead_ns) return Refusal::ahead;
  if (timestamp_ns < now_ns - age_ns) return Refusal::late;
  if (in_order) {
    if (input.sender != 0 && input.sender != sender && now_ns - input.heard_ns <= age_ns) return Refusal::other_sender;
    input.sender = sender;
    input.heard_ns = now_ns;
    if (timestamp_ns <= input.newest_ns) return Refusal::backwards;
  }
  return Refusal::none;
}

Refusal Inputs::settle(Input& input, Refusal refusal, int64_t timestamp_ns) {
  if (refusal == Refusal::none) {
    input.newest_ns = timestamp_ns;
    ++input.tally.accepted;
    ++input.tally.in_step;
  } else {
    input.tally.last_refusal = refusal;
    ++input.tally.refused;
  }
  return refusal;
}

/// A tenth of a second of grace in time, as stamps are not exact, and 2 cm and 2 degrees for the resolution of wheels.
bool Inputs::moves_steadily(const OdometryMessage& from, const OdometryMessage& to) const {
  const double time = std::max(0.0, seconds(to.timestamp_ns - from.timestamp_ns)) + 0.01;
  const double way = std::hypot(to.x - from.x, to.y - from.y), turn = std::abs(std::remainder(to.yaw - from.yaw, 2 * M_PI));
  return way <= config_.control.maxSpeed * time + 0.02 && turn <= config_.control.maxTurn * time + 0.035;
}

/// A jump is refused, but not for ever: where the samples after it go on steadily the odometry began anew, in a frame of its own.
Refusal Inputs::judge_motion(const OdometryMessage& message) {
  const bool first = odometry_.input.newest_ns == INT64_MIN;
  if (first || moves_steadily(last_, message)) {
    elsewhere_since_ = 0;
    return Refusal::none;
  }
  const bool steady = elsewhere_since_ != 0 && message.timestamp_ns > elsewhere_.timestamp_ns && moves_steadily(elsewhere_, message);
  if (!steady) elsewhere_since_ = message.timestamp_ns;
  elsewhere_ = message;
  if (message.timestamp_ns - elsewhere_since_ < lasting_ns) return Refusal::jump;
  elsewhere_since_ = 0;
  ++frame_;
  return Refusal::none;
}

Refusal Inputs::take(const OdometryMessage& message, uint64_t sender, int64_t now_ns) {
  Refusal refusal = recorded_ ? Refusal::recorded : sound(message);
  if (refusal == Refusal::none) refusal = judge(odometry_.input, message.timestamp_ns, sender, now_ns, true);
  if (refusal == Refusal::none) refusal = judge_motion(message);
  if (settle(odometry_.input, refusal, message.timestamp_ns) != Refusal::none) return refusal;
  last_ = message;
  Odometry& newest = odometry_.newest;
  newest = {};
  newest.timestamp_ns = message.timestamp_ns;
  newest.x = message.x;
  newest.y = message.y;
  newest.z = message.z;
  newest.roll = message.roll;
  newest.pitch = message.pitch;
  newest.yaw = message.yaw;
  newest.speed = message.speed;
  newest.turn_rate = message.turn_rate;
  newest.position_deviation = message.position_deviation;
  newest.yaw_deviation = message.yaw_deviation;
  newest.frame = frame_;
  return refusal;
}

Refusal Inputs::take(const ImuMessage& message, uint64_t sender, int64_t now_ns) {
  Refusal refusal = recorded_imu_ ? Refusal::recorded : sound(message);
  if (refusal == Refusal::none) refusal = judge(imu_.input, message.timestamp_ns, sender, now_ns, true);
  if (settle(imu_.input, refusal, message.timestamp_ns) != Refusal::none) return refusal;
  Imu& newest = imu_.newest;
  newest.timestamp_ns = message.timestamp_ns;
  std::copy_n(message.acceleration, 3, newest.acceleration);
  std::copy_n(message.rate, 3, newest.rate);
  const auto& a = message.acceleration;
  newest.roll = std::atan2(a[1], a[2]);
  newest.pitch = std::atan2(-a[0], std::hypot(a[1], a[2]));
  return refusal;
}

Refusal Inputs::take(const DriveMessage& message, uint64_t sender, int64_t now_ns) {
  Refusal refusal = recorded_orders_ ? Refusal::recorded : sound(message);
  if (refusal == Refusal::none) refusal = judge(drive_.input, message.timestamp_ns, sender, now_ns, true);
  if (settle(drive_.input, refusal, message.timestamp_ns) != Refusal::none) return refusal;
  drive_.newest.timestamp_ns = message.timestamp_ns;
  drive_.newest.speed = message.speed;
  drive_.newest.turn_rate = message.turn_rate;
  return refusal;
}

/// Events may come from many, in any order.
Refusal Inputs::take(const EventMessage& message, uint64_t sender, int64_t now_ns) {
  Refusal refusal = recorded_orders_ ? Refusal::recorded : sound(message);
  if (refusal == Refusal::none) refusal = judge(events_.input, message.timestamp_ns, sender, now_ns, false);
  const int64_t newest_ns = std::max(events_.input.newest_ns, message.timestamp_ns);
  if (settle(events_.input, refusal, newest_ns) != Refusal::none) return refusal;
  Events& events = events_.newest;
  std::copy_backward(events.entries, events.entries + Events::capacity - 1, events.entries + Events::capacity);
  events.entries[0].timestamp_ns = message.timestamp_ns;
  std::memcpy(events.entries[0].label, message.label, sizeof message.label);
  if (std::string_view(message.label) == recording_label) recording_begins_ = true;
  events.count = std::min(events.count + 1, Events::capacity);
  return refusal;
}

void Inputs::forget(uint64_t sender) {
  for (Input* input : {&odometry_.input, &imu_.input, &drive_.input, &events_.input})
    if (input->sender == sender) input->sender = 0;
}

bool Inputs::write_age(Input& input, Image& image, Reason none, int64_t now_ns, double& age_s) const {
  input.tally.in_step = 0;
  const bool ever = input.newest_ns != INT64_MIN;
  image.timestamp_ns = ever ? input.newest_ns : 0;
  age_s = ever ? seconds(now_ns - input.newest_ns) : std::nan("");
  if (ever && age_s <= config_.control.maxAge) return true;
  image.set_blind(none);
  return false;
}

namespace {
template <class Record>
Record& fill(Image& image, const Record& newest, const InputTally& tally) {
  const RecordHeader header = make_record<Record>(image).header;
  Record& record = *image.row<Record>(0);
  record = newest;
  record.header = header;
  record.tally = tally;
  return record;
}
}  // namespace

void Inputs::write_odometry(Image& image, int64_t now_ns) {
  Odometry& record = fill(image, odometry_.newest, odometry_.input.tally);
  write_age(odometry_.input, image, Reason::no_odometry, now_ns, record.age_s);
}
void Inputs::write_imu(Image& image, int64_t now_ns) {
  Imu& record = fill(image, imu_.newest, imu_.input.tally);
  write_age(imu_.input, image, Reason::no_imu, now_ns, record.age_s);
}
void Inputs::write_drive(Image& image, int64_t now_ns) {
  DriveOrder& record = fill(image, drive_.newest, drive_.input.tally);
  write_age(drive_.input, image, Reason::no_drive, now_ns, record.age_s);
}
void Inputs::write_events(Image& image, int64_t now_ns) {
  Events& record = fill(image, events_.newest, events_.input.tally);
  write_age(events_.input, image, Reason::no_event, now_ns, record.age_s);
}

}  // namespace vdisp
