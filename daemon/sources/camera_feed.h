// camera_feed.h: one camera at work in a thread of its own: opened, opened again, its frames turned into gray views.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "daemon/sources/camera.h"
#include "daemon/sources/camera_clock.h"
#include "daemon/sources/exposure.h"
#include "daemon/sources/frame_pairs.h"
#include "daemon/sources/raw_pixels.h"
#include "ipc/records.h"

namespace vdisp {

/// Where the frames of all feeds go. All members but the first are called by feeds.
class FrameTaker {
 public:
  virtual ~FrameTaker() = default;
  /// Views of a slot that nobody uses, one or two; `slot` -1: all are in use.
  virtual std::vector<GrayView> borrow(int& slot) = 0;
  virtual void deliver(int side, const WaitingFrame& frame) noexcept = 0;
  virtual void give_back(int slot) noexcept = 0;
  /// A camera opened, or failed to, or was lost: what came from it before belongs to nothing that comes now.
  virtual void changed(int side) noexcept = 0;
  /// Called when a camera is open, before its first frame; what is wrong with its format, or empty.
  virtual std::string refuse(int side, const FrameFormat& format) = 0;
};

class CameraFeed {
 public:
  struct State {
    bool tried = false, open = false;
    CameraFault fault = CameraFault::failed;
    std::string problem;  ///< why it is not open, or what was wrong with the last frame; empty: nothing
    FrameFormat format;
    CameraView view{};
    std::string stored_calibration;
  };
  struct Settings {
    bool both_views = false;
    bool waits_for_signal = false;  ///< trigger = line: no frames is no fault of the camera
  };

  /// The taker and `exchanged` must outlive the feed.
  CameraFeed(std::unique_ptr<Camera> camera, int side, FrameTaker& taker, const std::atomic<bool>& exchanged, Settings settings);
  ~CameraFeed();
  void start();
  /// Ends the thread; the camera is closed then.
  void stop();

  State state() const;
  /// Of it, what costs no allocation; false: there is no problem.
  CameraView view() const;
  bool add_problem(std::string& text) const;
  /// Sets exposure and gain as soon as the camera can.
  void want(const ExposureSetting& setting);
  /// Not while it opens or closes: the other camera is not kept waiting.
  void trigger() noexcept;
  const std::string& name() const { return camera_->name(); }
  /// What happened to it since the last call, once each: opened, lost, back, or another reason why it is not open. Empty: nothing.
  enum class News : uint8_t { nothing, opened, lost, back, waits };
  News take_news();
  /// What is wrong with it now is told by other means.
  void keep_quiet_of_fault();
  double longest_exposure() const;
  double highest_gain() const;

 private:
  void run() noexcept;
  bool open();
  void deliver_frames() noexcept;
  void take(const RawFrame& frame) noexcept;
  int64_t when(const RawFrame& frame) noexcept;
  void apply_exposure() noexcept;
  void note_problem(CameraFault fault, std::string problem) noexcept;
  bool pause(std::chrono::milliseconds time);

  std::unique_ptr<Camera> camera_;
  const int side_;
  FrameTaker& taker_;
  const std::atomic<bool>& exchanged_;
  const Settings settings_;
  RawPixels pixels_;
  CameraClock clock_;
  std::mutex device_;  ///< open and close against trigger
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  State state_;
  std::optional<ExposureSetting> wanted_, steered_;  // not set yet; set last
  double longest_exposure_ = 0, highest_gain_ = 0;
  bool stopping_ = false;
  News told_ = News::nothing;
  std::optional<CameraFault> told_fault_;
  std::thread thread_;
};

}  // namespace vdisp
