// tracks.cpp: blobs to tracks: predict, associate, update.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/tracks.h"

#include <algorithm>
#include <bitset>
#include <cmath>

namespace vdisp {
namespace {

constexpr double restlessness = 0.2;                         // m/s in a second, standard deviation of how speeds change
constexpr double first_speed = 1.5;                          // m/s, standard deviation of the speed of what is new
constexpr double nearest = 0.25;                             // m: within this a blob continues a track in any case
constexpr double farthest = 1.0;                             // m
constexpr double deviations = 3;                             // of the uncertainty
constexpr double unseen_s = 1;                               // as long a track goes on without being seen
constexpr double cut_deviation = 0.3;                        // m, of the middle of what the border of the view cuts
constexpr double lately = 0.97;                              // of a size, from frame to frame
constexpr double least_change = 0.12, changed_share = 0.25;  // m, and of the size
constexpr int least_sights = 3;
constexpr double sure = 2.5;          // deviations of the speed from 0 of what moves
constexpr double least_moving = 0.2;  // m/s

double seconds(int64_t ns) { return static_cast<double>(ns) * 1e-9; }

}  // namespace

std::vector<ImageSpec> ObstacleTracks::check(std::span<const ImageSpec> in) {
  if (in.size() != 6)
    throw FormatError("takes occupancy, reason, standing, height, floor model and memory, was given " + std::to_string(in.size()) +
                      " images");
  require(in[0], Pixel::int8, "the occupancy");
  require(in[1], Pixel::gray8, "the reason");
  require_same_size(in[0], in[1]);
  require(in[2], Pixel::disparity16, "what stands");
  require(in[3], Pixel::height16, "the height");
  require_same_size(in[2], in[3]);
  if (in[4] != record_spec<FloorModel>()) throw FormatError("the fifth input is no floor model");
  if (in[5] != record_spec<Memory>()) throw FormatError("the sixth input is no memory");
  blobs_.reserve(in[0], in[2]);
  followed_.reserve(Tracks::capacity);
  followed_.clear();
  return {record_spec<Tracks>()};
}

void ObstacleTracks::predict(double t) noexcept {
  const double change = restlessness * restlessness * t;  // of the speed, as variance
  for (Followed& f : followed_) {
    f.x += f.speed_x * t;
    f.y += f.speed_y * t;
    f.place_variance += t * (2 * f.common + t * f.speed_variance) + change * t * t / 3;
    f.common += t * f.speed_variance + change * t / 2;
    f.speed_variance += change;
    f.seen = false;
  }
}

/// Cut, or of another size than lately: something hides a part of it, or shows more of it.
bool ObstacleTracks::partly_seen(Followed& f, const Blob& blob) noexcept {
  const double size = blob.size_x + blob.size_y;
  f.greatest = std::max(size, f.greatest * lately);
  f.smallest = std::min(size, f.smallest / lately);
  const double change = std::max(f.greatest - size, size - f.smallest);
  return blob.cut || f.last.cut || (change > least_change && change > changed_share * f.greatest);
}

void ObstacleTracks::update(Followed& f, const Blob& blob, int64_t now_ns) noexcept {
  // The middle of what is seen in part moves as the view does: it tells no speed.
  const bool cut = partly_seen(f, blob);
  const double variance = cut ? cut_deviation * cut_deviation : blob.deviation * blob.deviation, all = f.place_variance + variance;
  const double of_place = f.place_variance / all, of_speed = cut ? 0 : f.common / all, rest = 1 - of_place;
  const double dx = blob.x - f.x, dy = blob.y - f.y;
  f.x += of_place * dx;
  f.y += of_place * dy;
  f.speed_x += of_speed * dx;
  f.speed_y += of_speed * dy;
  f.speed_variance -= of_speed * f.common;
  f.common *= rest;
  f.place_variance = rest * f.place_variance;
  f.last = blob;
  f.seen = true;
  f.seen_ns = now_ns;
  ++f.sights;
}

void ObstacleTracks::begin(const Blob& blob, int64_t now_ns) noexcept {
  if (followed_.size() == Tracks::capacity) return;
  const double place = blob.deviation * blob.deviation;
  followed_.push_back({next_id_++, blob.x, blob.y, 0, 0, place, 0, first_speed * first_speed, blob, blob.size_x + blob.size_y,
                       blob.size_x + blob.size_y, 1, now_ns, now_ns, true});
}

void ObstacleTracks::associate(std::span<const Blob> blobs, int64_t now_ns) noexcept {
  // Before anything is taken for one of them: steps without a frame are not followed.
  std::erase_if(followed_, [&](const Followed& f) { return seconds(now_ns - f.seen_ns) > unseen_s; });
  std::bitset<Blobs::most> taken;
  for (Followed& f : followed_) {
    const double room = std::clamp(nearest + deviations * std::sqrt(f.place_variance), nearest, farthest);
    size_t best = blobs.size();
    double least = room;
    for (size_t i = 0; i < blobs.size(); ++i) {
      const double distance = std::hypot(blobs[i].x - f.x, blobs[i].y - f.y);
      if (taken[i] || distance >= least) continue;
      least = distance;
      best = i;
    }
    if (best == blobs.size()) continue;
    taken[best] = true;
    update(f, blobs[best], now_ns);
  }
  for (size_t i = 0; i < blobs.size(); ++i)
    if (!taken[i]) begin(blobs[i], now_ns);
}

void ObstacleTracks::tell(Tracks& tracks, int64_t now_ns) const noexcept {
  tracks.frame = frame_;
  for (const Followed& f : followed_) {
    if (f.sights < least_sights) continue;
    const double speed = std::hypot(f.speed_x, f.speed_y), deviation = std::sqrt(f.speed_variance);
    const bool moves = speed > std::max(least_moving, sure * deviation);
    Track& t = tracks.tracks[tracks.count++];
    t.id = f.id;
    t.flags = (moves ? Track::moving : 0) | (f.seen ? Track::seen : 0) | (f.last.cut ? Track::cut : 0);
    t.x = static_cast<float>(f.x);
    t.y = static_cast<float>(f.y);
    t.speed_x = static_cast<float>(f.speed_x);
    t.speed_y = static_cast<float>(f.speed_y);
    t.speed_deviation = static_cast<float>(deviation);
    t.size_x = static_cast<float>(f.last.size_x);
    t.size_y = static_cast<float>(f.last.size_y);
    t.height = static_cast<float>(f.last.height);
    t.age_s = static_cast<float>(seconds(now_ns - f.first_ns));
    t.unseen_s = static_cast<float>(seconds(now_ns - f.seen_ns));
  }
}

void ObstacleTracks::begin_anew() noexcept {
  followed_.clear();  // numbers go on: none is used again
  forgotten_ = frame_ = 0;
  last_ns_ = 0;
}

Outcome ObstacleTracks::process(std::span<const Image* const> in, std::span<Image* const> out) noexcept {
  const Memory& memory = *in[5]->row<Memory>(0);
  const int64_t now_ns = in[0]->timestamp_ns;
  const bool placed = std::isfinite(memory.x);
  const uint32_t frame = placed ? grid_of_odometry : grid_of_camera;
  // Contradiction is found in the tracks themselves: they live on.
  const bool elsewhere = memory.forgotten != forgotten_ && memory.cause != MemoryCause::contradicted;
  if (frame != frame_ || elsewhere || now_ns < last_ns_) followed_.clear();
  frame_ = frame;
  forgotten_ = memory.forgotten;
  const Placement placement(config_.mounting, placed ? memory.x : 0, placed ? memory.y : 0, placed ? memory.yaw : 0);
  predict(seconds(now_ns - last_ns_));
  associate(blobs_.find({*in[0], *in[1], *in[2], *in[3], *in[4]->row<FloorModel>(0)}, placement), now_ns);
  last_ns_ = now_ns;
  out[0]->flags |= flag_memory;
  tell(make_record<Tracks>(*out[0]), now_ns);
  return Outcome::valid;
}

}  // namespace vdisp
