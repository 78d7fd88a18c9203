// live.cpp: opening: which size, which calibration, what is refused.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sources/live.h"

#include <sysexits.h>

#include <algorithm>
#include <chrono>
#include <cstdio>

#include "daemon/core/clock.h"
#include "daemon/sources/live_source.h"

namespace vdisp {
namespace {

constexpr std::chrono::seconds longest_start{4};
constexpr size_t longest_fault = 1000;
constexpr int default_width = 640, default_height = 480;  // the paper's

std::string size_text(int width, int height) { return std::to_string(width) + "x" + std::to_string(height); }

}  // namespace

std::unique_ptr<StereoSource> open_live(const Config& config, std::vector<std::unique_ptr<Camera>> cameras) {
  return std::make_unique<LiveSource>(config, std::move(cameras));
}

LiveSource::LiveSource(const Config& config, std::vector<std::unique_ptr<Camera>> cameras)
    : config_(config),
      pairs_(static_cast<int64_t>(config.camera.tolerance * 1e6), config.camera.pairing == "count" ? PairBy::count : PairBy::time),
      exchanged_(config.camera.swap == "yes"),
      order_known_(config.camera.swap != "auto") {
  const CameraFeed::Settings settings{cameras.size() == 1, config.camera.trigger == "line"};
  // Two cameras that are exchanged are just called so.
  const bool turned = cameras.size() == 2 && config.camera.swap == "yes";
  for (size_t i = 0; i < cameras.size(); ++i)
    feeds_.push_back(std::make_unique<CameraFeed>(std::move(cameras[i]), turned ? 1 - static_cast<int>(i) : static_cast<int>(i), *this,
                                                  exchanged_, settings));
  if (turned) std::swap(feeds_[0], feeds_[1]);
  fault_.reserve(longest_fault);
  try {
    start();
  } catch (...) {
    stop();  // their threads know this source
    throw;
  }
}

void LiveSource::start() {
  if (!config_.image_source.paramfile.empty()) calibration_ = read_calibration(config_.image_source.paramfile);
  for (auto& feed : feeds_) feed->start();
  if (config_.camera.trigger == "software") {
    const auto start = std::chrono::steady_clock::now();
    for (auto& feed : feeds_) triggers_.emplace_back([this, &feed = *feed, start] { trigger(feed, start); });
  }
  wait_for_cameras();
  choose_size();
  choose_calibration();
  make_slots();
  for (auto& feed : feeds_) feed->keep_quiet_of_fault();  // the first blind frame tells
  const std::lock_guard lock(mutex_);
  settled_ = true;
  last_pair_ns_ = monotonic_ns();
}

LiveSource::~LiveSource() { stop(); }

void LiveSource::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  for (std::thread& trigger : triggers_) trigger.join();
  triggers_.clear();
  for (auto& feed : feeds_) feed->stop();
}

/// Until each has opened, or failed to in a way that waiting does not heal. What cannot be had at all ends the start.
void LiveSource::wait_for_cameras() {
  const auto settled = [&] {
    return std::all_of(feeds_.begin(), feeds_.end(), [](const auto& feed) {
      const CameraFeed::State state = feed->state();
      return state.open || (state.tried && (state.fault == CameraFault::denied || state.fault == CameraFault::unsupported));
    });
  };
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, longest_start, settled);
  for (const auto& feed : feeds_) {
    const CameraFeed::State state = feed->state();
    if (state.open || !state.tried) continue;
    if (state.fault == CameraFault::denied) throw SourceError(EX_NOPERM, state.problem);
    if (state.fault == CameraFault::unsupported) throw SourceError(EX_CONFIG, state.problem);
  }
}

void LiveSource::choose_size() {
  int width = config_.image_source.width, height = config_.image_source.height;
  for (const auto& feed : feeds_) {
    const CameraFeed::State state = feed->state();
    if (!state.open) continue;
    if ((width != 0 && width != state.format.width) || (height != 0 && height != state.format.height))
      throw SourceError(EX_CONFIG, feed->name() + " gives " + size_text(state.format.width, state.format.height) + ", needed is " +
                                       size_text(width, height) + ": [image source] width and height, or the other camera's");
    width = state.format.width;
    height = state.format.height;
  }
  if ((width == 0 || height == 0) && calibration_ && calibration_->width != 0) width = calibration_->width, height = calibration_->height;
  if (width == 0 || height == 0) width = default_width, height = default_height;
  if (calibration_ && calibration_->width != 0 && (calibration_->width != width || calibration_->height != height))
    throw SourceError(EX_CONFIG, "the cameras give " + size_text(width, height) + ", the calibration " + config_.image_source.paramfile +
                                     " is for " + size_text(calibration_->width, calibration_->height));
  spec_ = {Pixel::gray8, 0, static_cast<uint16_t>(width), static_cast<uint16_t>(height)};
}

void LiveSource::choose_calibration() {
  if (calibration_) return;
  const CameraFeed::State state = feeds_[0]->state();
  if (state.stored_calibration.empty()) return;
  calibration_ = parse_calibration("the memory of " + feeds_[0]->name(), state.stored_calibration);
  news_.push_back("calibration (" + calibration_->format + ") from the memory of " + feeds_[0]->name());
}

void LiveSource::make_slots() {
  const std::lock_guard lock(mutex_);
  const size_t bytes = static_cast<size_t>(spec_.stride()) * spec_.height * (both_views() ? 2 : 1);
  // What waits on both sides, the pair that is ready, the one that is read, and what is being written.
  slots_.resize(2 * FramePairs::capacity + 6);
  for (Slot& slot : slots_) slot.pixels.resize(bytes);
  order_.prepare(spec_);
}

/// What the format of a camera contradicts; before the size is chosen nothing but the mosaic.
std::string LiveSource::refuse(int, const FrameFormat& format) {
  const std::string& bayer = config_.image_source.bayer;
  if (format.pixels == FramePixels::bayer8 && !format.bayer.empty() && format.bayer != bayer)
    return "it gives a Bayer mosaic that begins " + format.bayer + ", [image source] bayer is " + bayer + "; needed is " + format.bayer;
  const std::lock_guard lock(mutex_);
  if (!settled_ || (format.width == spec_.width && format.height == spec_.height)) return {};
  return "it gives " + size_text(format.width, format.height) + ", the tree was built for " + size_text(spec_.width, spec_.height) +
         "; set [image source] width and height, or start vdispd again";
}

std::string LiveSource::describe_opened(const CameraFeed& feed) const {
  static constexpr const char* pixels[] = {"gray8", "gray10", "gray12", "gray16", "Bayer 8", "RGB", "BGR", "YUYV", "UYVY", "JPEG"};
  const FrameFormat format = feed.state().format;
  char rate[32] = "";
  if (format.period_s > 0) std::snprintf(rate, sizeof rate, ", %.4g Hz", 1 / format.period_s);
  return feed.name() + " opened: " + size_text(format.width, format.height) + " " + pixels[static_cast<size_t>(format.pixels)] +
         (format.views == FrameViews::one      ? ""
          : format.views == FrameViews::beside ? ", both views side by side"
                                               : ", both views by turns") +
         rate;
}

void LiveSource::tell(CameraFeed& feed) {
  switch (feed.take_news()) {
    case CameraFeed::News::nothing: break;
    case CameraFeed::News::opened:
      news_.push_back(describe_opened(feed));
      if (!calibration_ && !feed.state().stored_calibration.empty())
        news_.push_back(feed.name() + " came after the start: the calibration in its memory is used when vdispd is started again");
      period_ns_ = std::max(period_ns_, static_cast<int64_t>(feed.state().format.period_s * 1e9));
      break;
    case CameraFeed::News::back: news_.push_back(feed.name() + " is back"); break;
    case CameraFeed::News::lost: news_.push_back("lost a camera: " + feed.state().problem); break;
    case CameraFeed::News::waits: news_.push_back(feed.state().problem + "; it is looked for"); break;
  }
}

bool LiveSource::news(std::string& line) {
  for (const auto& feed : feeds_) tell(*feed);
  if (news_.empty()) return false;
  line = std::move(news_.front());
  news_.pop_front();
  return true;
}

/// `rate` times a second. Each camera has a thread of its own: one that died makes its own wait for an answer, not the other's.
void LiveSource::trigger(CameraFeed& feed, std::chrono::steady_clock::time_point start) {
  const double rate = config_.image_source.rate > 0 ? config_.image_source.rate : default_trigger_rate;
  const auto period = std::chrono::nanoseconds(static_cast<int64_t>(1e9 / rate));
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    lock.unlock();
    feed.trigger();
    lock.lock();
    // The next beat of both: those that are over by now are left out.
    const auto due = start + ((std::chrono::steady_clock::now() - start) / period + 1) * period;
    changed_.wait_until(lock, due, [&] { return stopping_; });
  }
}

}  // namespace vdisp
