// odometry_check.cpp: odometry carried to the time of the frame, and what speaks against it.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/odometry_check.h"

#include <cmath>

namespace vdisp {
namespace {

constexpr double longest_pause_s = 1;                                // the rover may have been carried meanwhile
constexpr double grace_m = 0.02, grace_rad = 0.035, grace_s = 0.01;  // as at the control socket: wheels have a resolution
constexpr double mature_s = 0.7;                                     // age of a track whose speed counts
constexpr int least_tracks = 3;                                      // three points: six speeds against three of a rigid motion
constexpr double least_speed = 0.25;                                 // m/s, root mean square
constexpr double least_share = 0.65;                                 // of the speeds, that one rigid motion explains
constexpr int64_t contradiction_ns = 500'000'000, trust_again_ns = 1'000'000'000;

double seconds(int64_t ns) { return static_cast<double>(ns) * 1e-9; }
double turn(double from, double to) { return std::remainder(to - from, 2 * M_PI); }

/// True where the seen tracks move like the points of one rigid body, and do move: v = t + w x r, by least squares.
bool move_as_one(const Tracks& tracks) {
  const Track* used[Tracks::capacity];
  int n = 0;
  double x = 0, y = 0, vx = 0, vy = 0;
  for (uint32_t i = 0; i < tracks.count; ++i) {
    const Track& t = tracks.tracks[i];
    if (!(t.flags & Track::seen) || static_cast<double>(t.age_s) < mature_s) continue;
    used[n++] = &t;
    x += static_cast<double>(t.x), y += static_cast<double>(t.y);
    vx += static_cast<double>(t.speed_x), vy += static_cast<double>(t.speed_y);
  }
  if (n < least_tracks) return false;
  x /= n, y /= n, vx /= n, vy /= n;
  double cross = 0, square = 0, all = 0, about = 0;
  for (int i = 0; i < n; ++i) {
    const double rx = static_cast<double>(used[i]->x) - x, ry = static_cast<double>(used[i]->y) - y;
    const double ux = static_cast<double>(used[i]->speed_x), uy = static_cast<double>(used[i]->speed_y);
    cross += rx * (uy - vy) - ry * (ux - vx);
    square += rx * rx + ry * ry;
    all += ux * ux + uy * uy;
    about += (ux - vx) * (ux - vx) + (uy - vy) * (uy - vy);
  }
  const double turning = square > 0 ? cross * cross / square : 0;  // of the speeds' squares, what the turn explains
  return all / n >= least_speed * least_speed && about - turning <= (1 - least_share) * (1 - least_share) * all;
}

}  // namespace

std::vector<ImageSpec> OdometryCheck::check(std::span<const ImageSpec> in) {
  if (in.size() != 3)
    throw FormatError("takes an image of the frame, odometry and tracks, was given " + std::to_string(in.size()) + " images");
  if (in[1] != record_spec<Odometry>()) throw FormatError("the second input is no odometry");
  if (in[2] != record_spec<Tracks>()) throw FormatError("the third input is no tracks");
  return {record_spec<Memory>()};
}

void OdometryCheck::forget(MemoryCause why, int64_t now_ns) noexcept {
  ++forgotten_;
  why_ = why;
  since_ns_ = now_ns;
  has_used_ = false;
}

void OdometryCheck::keep(const Odometry& o) noexcept {
  if (samples_ > 0 && o.timestamp_ns == newest_.timestamp_ns) return;
  before_ = newest_;
  newest_ = {o.timestamp_ns, o.x, o.y, o.yaw, o.speed, o.turn_rate};
  if (++samples_ == 1) before_ = newest_;
}

/// Between the two newest samples a straight line; after the newest on at its speed, told or as the line says.
OdometryCheck::Sample OdometryCheck::carried(int64_t to_ns) const noexcept {
  const double between = seconds(newest_.timestamp_ns - before_.timestamp_ns), after = seconds(to_ns - newest_.timestamp_ns);
  Sample at = newest_;
  at.timestamp_ns = to_ns;
  if (after > 0 && std::isfinite(newest_.speed) && std::isfinite(newest_.turn_rate)) {
    const double way = newest_.speed * after, middle = newest_.yaw + newest_.turn_rate * after / 2;
    at.x += way * std::cos(middle);
    at.y += way * std::sin(middle);
    at.yaw += newest_.turn_rate * after;
  } else if (between > 0 && between <= longest_pause_s) {
    const double part = std::max(after / between, -1.0);
    at.x += (newest_.x - before_.x) * part;
    at.y += (newest_.y - before_.y) * part;
    at.yaw += turn(before_.yaw, newest_.yaw) * part;
  }
  return at;
}

bool OdometryCheck::jumped(const Sample& from, const Sample& to) const noexcept {
  const double time = seconds(to.timestamp_ns - from.timestamp_ns) + grace_s;
  return std::hypot(to.x - from.x, to.y - from.y) > config_.control.maxSpeed * time + grace_m ||
         std::abs(turn(from.yaw, to.yaw)) > config_.control.maxTurn * time + grace_rad;
}

/// True from half a second after all began to move as one until they have not for a second.
bool OdometryCheck::contradicted(const Image& tracks, int64_t now_ns) noexcept {
  const Tracks* record = tracks.valid() ? record_of<Tracks>(tracks) : nullptr;
  if (record && record->frame == grid_of_odometry && move_as_one(*record)) {
    if (as_one_since_ns_ < 0) as_one_since_ns_ = now_ns;
    as_one_ns_ = now_ns;
  } else if (as_one_since_ns_ >= 0) {
    // Before it lasts one look otherwise refutes it.
    if (as_one_ns_ - as_one_since_ns_ < contradiction_ns || now_ns - as_one_ns_ >= trust_again_ns) as_one_since_ns_ = -1;
  }
  return as_one_since_ns_ >= 0 && as_one_ns_ - as_one_since_ns_ >= contradiction_ns;
}

/// Why there is no memory in this frame; none if there is. Writes the pose where there is one.
MemoryCause OdometryCheck::judge(const Image& frame, const Image& odometry, Memory& memory) noexcept {
  const Odometry& o = *odometry.row<Odometry>(0);
  const int64_t now_ns = frame.timestamp_ns;
  if (!odometry.valid() || !std::isfinite(o.x) || !std::isfinite(o.y) || !std::isfinite(o.yaw)) return MemoryCause::no_odometry;
  if (samples_ > 0 && (o.frame != frame_ || o.timestamp_ns < newest_.timestamp_ns)) {
    forget(o.frame != frame_ ? MemoryCause::anew : MemoryCause::backwards, now_ns);
    samples_ = 0;
  }
  frame_ = o.frame;
  keep(o);
  // What was recorded from cameras is as it was then: times of frames and of odometry are those of one clock.
  constexpr uint32_t made_up = flag_synthetic | flag_replayed;
  const bool of_frame = (odometry.flags & made_up) == flag_synthetic, made = (frame.flags & made_up) == flag_synthetic;
  const int64_t taken_ns = of_frame ? o.timestamp_ns : made ? o.timestamp_ns + static_cast<int64_t>(o.age_s * 1e9) : now_ns;
  memory.lag_s = seconds(taken_ns - o.timestamp_ns);
  if (memory.lag_s > config_.memory.maxLag) return MemoryCause::late;
  Sample pose = carried(taken_ns);
  if (has_used_ && seconds(taken_ns - used_.timestamp_ns) > longest_pause_s) forget(MemoryCause::pause, now_ns);
  if (has_used_ && jumped(used_, pose)) forget(MemoryCause::jump, now_ns);
  used_ = pose;
  has_used_ = true;
  memory.x = pose.x;
  memory.y = pose.y;
  memory.yaw = std::remainder(pose.yaw, 2 * M_PI);
  return MemoryCause::none;
}

void OdometryCheck::begin_anew() noexcept {
  before_ = newest_ = used_ = {};
  samples_ = 0;
  frame_ = 0;
  ++forgotten_;  // never back: coordinates that a reader kept mean nothing now
  why_ = MemoryCause::none;
  last_ns_ = since_ns_ = 0;
  has_used_ = has_last_ = contradicts_ = false;
  as_one_since_ns_ = as_one_ns_ = -1;
}

Outcome OdometryCheck::process(std::span<const Image* const> in, std::span<Image* const> out) noexcept {
  const Image& frame = *in[0];
  const int64_t now_ns = frame.timestamp_ns;
  Memory& memory = make_record<Memory>(*out[0]);
  memory.x = memory.y = memory.yaw = memory.lag_s = std::nan("");
  if (!has_last_) since_ns_ = now_ns;
  if (has_last_ && now_ns < last_ns_) {
    forget(MemoryCause::backwards, now_ns);
    as_one_since_ns_ = -1;
  }
  MemoryCause cause = judge(frame, *in[1], memory);
  const bool contradicts = contradicted(*in[2], now_ns);
  if (contradicts && !contradicts_) forget(MemoryCause::contradicted, now_ns);
  contradicts_ = contradicts;
  if (contradicts && cause == MemoryCause::none) {
    cause = MemoryCause::contradicted;
    since_ns_ = now_ns;
  }
  memory.state = cause == MemoryCause::none ? MemoryState::fused : MemoryState::frame_only;
  memory.cause = cause == MemoryCause::none ? why_ : cause;
  memory.forgotten = forgotten_;
  memory.since_s = cause == MemoryCause::none ? seconds(now_ns - since_ns_) : 0;
  last_ns_ = now_ns;
  has_last_ = true;
  return Outcome::valid;
}

}  // namespace vdisp
