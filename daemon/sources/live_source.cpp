// live_source.cpp: from slots of frames to pairs, and why there is none.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sources/live_source.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "daemon/core/clock.h"

namespace vdisp {
namespace {

constexpr int64_t least_patience_ns = 100'000'000;
constexpr double periods_of_patience = 2.5;

}  // namespace

std::vector<GrayView> LiveSource::borrow(int& slot) {
  const std::lock_guard lock(mutex_);
  slot = -1;
  const auto free = std::find_if(slots_.begin(), slots_.end(), [](const Slot& s) { return !s.used; });
  if (free == slots_.end()) return {};
  free->used = true;
  slot = static_cast<int>(free - slots_.begin());
  const auto stride = static_cast<ptrdiff_t>(spec_.stride());
  std::vector<GrayView> views{{free->pixels.data(), spec_.width, spec_.height, stride}};
  if (both_views()) views.push_back({free->pixels.data() + stride * spec_.height, spec_.width, spec_.height, stride});
  return views;
}

void LiveSource::free_slot(int slot) noexcept {
  if (slot >= 0) slots_[static_cast<size_t>(slot)].used = false;
}

void LiveSource::give_back(int slot) noexcept {
  const std::lock_guard lock(mutex_);
  free_slot(slot);
}

void LiveSource::deliver(int side, const WaitingFrame& frame) noexcept {
  {
    const std::lock_guard lock(mutex_);
    std::optional<FramePair> pair;
    if (both_views()) {
      pair = FramePair{frame, frame};
    } else {
      pairs_.add(side, frame);
      pair = pairs_.take();
      for (int slot = pairs_.take_free(); slot >= 0; slot = pairs_.take_free()) free_slot(slot);
    }
    if (!pair) return;
    ++pairs_count_;
    if (ready_) {
      ++skipped_;
      free_slot(ready_->left.slot);
      free_slot(ready_->right.slot);
    }
    ready_ = pair;
  }
  changed_.notify_all();
}

void LiveSource::changed(int side) noexcept {
  {
    const std::lock_guard lock(mutex_);
    if (!both_views()) pairs_.restart(side);
    for (int slot = pairs_.take_free(); slot >= 0; slot = pairs_.take_free()) free_slot(slot);
  }
  changed_.notify_all();
}

/// A slow camera does not blind the tree between its frames.
bool LiveSource::wait(int timeout_ms) noexcept {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, std::chrono::milliseconds(timeout_ms), [&] { return ready_.has_value(); });
  if (ready_) return true;
  const auto patience = std::max(least_patience_ns, static_cast<int64_t>(periods_of_patience * static_cast<double>(period_ns_)));
  return monotonic_ns() - last_pair_ns_ > patience;
}

Outcome LiveSource::grab(std::span<Image* const> out) noexcept {
  fault_.clear();
  std::optional<FramePair> pair;
  {
    const std::lock_guard lock(mutex_);
    pair.swap(ready_);
    if (pair) last_pair_ns_ = monotonic_ns();
  }
  fill_status(pair ? &*pair : nullptr);
  if (!pair) {
    const int64_t now = monotonic_ns();
    for (Image* image : out) image->timestamp_ns = now;
    out[0]->set_blind(why_none());
    return Outcome::invalid;
  }
  write(*pair, out);
  {
    const std::lock_guard lock(mutex_);
    free_slot(pair->left.slot);
    free_slot(pair->right.slot);
  }
  steer_exposure(out);
  if (know_order(*pair, out)) return Outcome::valid;
  out[0]->set_blind(Reason::bad_pair);
  return Outcome::invalid;
}

void LiveSource::write(const FramePair& pair, std::span<Image* const> out) noexcept {
  const size_t bytes = static_cast<size_t>(spec_.stride()) * spec_.height;
  const WaitingFrame* frames[] = {&pair.left, &pair.right};
  for (size_t side = 0; side < 2; ++side) {
    const uint8_t* pixels = slots_[static_cast<size_t>(frames[side]->slot)].pixels.data() + (both_views() ? side * bytes : 0);
    // Bytes are laid out as in an Image; only two cameras may still be the wrong way round.
    Image& image = *out[!both_views() && exchanged_ && config_.camera.swap == "auto" ? 1 - side : side];
    std::memcpy(image.row<uint8_t>(0), pixels, bytes);
  }
  for (Image* image : out) {
    image->timestamp_ns = pair.left.when_ns / 2 + pair.right.when_ns / 2;
    if (calibration_) image->calibration_hash = calibration_->hash;
  }
}

/// False: which view is the left one is still being found out.
bool LiveSource::know_order(const FramePair& pair, std::span<Image* const> out) noexcept {
  // Frames with both views that were there before it was known are still the wrong way round.
  if (order_known_) return !both_views() || pair.left.when_ns > turned_ns_;
  const std::optional<bool> right_way = order_.see(*out[0], *out[1]);
  if (!right_way) {
    fault_ = "which view is the left one is not known yet: [camera] swap = auto needs texture that is near";
    return false;
  }
  order_known_ = true;
  if (!*right_way) exchanged_ = true, turned_ns_ = monotonic_ns();
  news_.push_back(*right_way ? "left and right are the right way round" : "left and right are exchanged, and put right");
  return *right_way;
}

void LiveSource::steer_exposure(std::span<Image* const> out) noexcept {
  Brightness both{};
  for (size_t side = 0; side < 2; ++side) {
    const Brightness one = brightness_of(*out[side]);
    status_.view[side].floor_level = one.floor_mean;
    status_.view[side].dark = one.dark;
    status_.view[side].bright = one.bright;
    both.floor_mean += one.floor_mean / 2;
    both.bright = std::max(both.bright, one.bright);
  }
  if (config_.camera.exposeBy != "floor") return;
  if (!exposure_) {
    double longest = config_.camera.longestExposure, gain = 0;
    for (const auto& feed : feeds_) {
      if (feed->longest_exposure() > 0) longest = std::min(longest, feed->longest_exposure());
      gain = &feed == &feeds_.front() ? feed->highest_gain() : std::min(gain, feed->highest_gain());
    }
    exposure_.emplace(ExposureSetting{config_.camera.exposure, config_.camera.gain}, longest, gain);
    for (auto& feed : feeds_) feed->want(exposure_->setting());
  }
  if (const auto setting = exposure_->see(both))
    for (auto& feed : feeds_) feed->want(*setting);
}

void LiveSource::fill_status(const FramePair* pair) noexcept {
  FramePairs::Tally tally;
  std::optional<int64_t> apart;
  {
    const std::lock_guard lock(mutex_);
    tally = pairs_.tally();
    apart = pairs_.apart_ns();
    status_.pairs = pairs_count_;
    status_.skipped = skipped_;
  }
  status_.cameras = static_cast<uint32_t>(feeds_.size());
  status_.exchanged = exchanged_;
  if (pair) apart = pair->right.when_ns - pair->left.when_ns;
  status_.apart_ms = apart ? static_cast<double>(*apart) * 1e-6 : std::nan("");
  status_.age_ms = pair ? static_cast<double>(monotonic_ns() - pair->left.when_ns) * 1e-6 : std::nan("");
  for (size_t side = 0; side < 2; ++side) {
    const double level = status_.view[side].floor_level, dark = status_.view[side].dark, bright = status_.view[side].bright;
    status_.view[side] = feeds_[std::min(side, feeds_.size() - 1)]->view();
    status_.view[side].unpaired = tally.unpaired[side];
    status_.view[side].refused = tally.refused[side];
    status_.view[side].floor_level = level, status_.view[side].dark = dark, status_.view[side].bright = bright;
  }
}

/// The reason, and in fault_ the line for the operator.
Reason LiveSource::why_none() noexcept {
  bool open = true, damaged = false;
  for (const auto& feed : feeds_) {
    const bool is_open = feed->view().open != 0;
    if (!fault_.empty()) fault_ += "; ";
    const bool told = feed->add_problem(fault_);
    if (!told && fault_.ends_with("; ")) fault_.resize(fault_.size() - 2);
    open = open && is_open;
    damaged = damaged || (is_open && told);
  }
  if (!open) return Reason::no_camera;
  if (damaged) return Reason::bad_frames;
  if (std::isnan(status_.apart_ms)) return Reason::no_frame;
  char text[200];
  std::snprintf(text, sizeof text,
                "right frames are taken %.2f ms after left ones, [camera] tolerance is %.4g ms: trigger the cameras, or allow more",
                status_.apart_ms, config_.camera.tolerance);
  fault_ = text;
  return Reason::unpaired;
}

}  // namespace vdisp
