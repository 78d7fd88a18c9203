// live_source.h: pairs from one or two cameras: slots for frames, pairing, exposure, and what is said when there is none.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "daemon/sources/camera_feed.h"
#include "daemon/sources/source.h"
#include "daemon/sources/view_order.h"

namespace vdisp {

class LiveSource final : public StereoSource, public FrameTaker {
 public:
  LiveSource(const Config& config, std::vector<std::unique_ptr<Camera>> cameras);
  ~LiveSource() override;

  std::vector<ImageSpec> open() override { return {spec_, spec_}; }
  Outcome grab(std::span<Image* const> out) noexcept override;
  std::optional<Calibration> calibration() const override { return calibration_; }
  /// The cameras' own pace: wait() ends when they deliver.
  int64_t period_ns() const override { return 0; }
  int64_t pair_period_ns() const override { return period_ns_; }
  std::string_view fault() const noexcept override { return fault_; }
  bool wait(int timeout_ms) noexcept override;
  void close() noexcept override { stop(); }
  const CameraStatus* cameras() const noexcept override { return &status_; }
  bool news(std::string& line) override;

 private:
  struct Slot {
    std::vector<uint8_t> pixels;
    bool used = false;
  };

  std::vector<GrayView> borrow(int& slot) override;
  void deliver(int side, const WaitingFrame& frame) noexcept override;
  void give_back(int slot) noexcept override;
  void changed(int side) noexcept override;
  std::string refuse(int side, const FrameFormat& format) override;

  bool both_views() const { return feeds_.size() == 1; }
  void start();
  void stop();
  void wait_for_cameras();
  void choose_size();
  void choose_calibration();
  void make_slots();
  void trigger(CameraFeed& feed, std::chrono::steady_clock::time_point start);
  void tell(CameraFeed& feed);
  std::string describe_opened(const CameraFeed& feed) const;
  void free_slot(int slot) noexcept;
  void write(const FramePair& pair, std::span<Image* const> out) noexcept;
  bool know_order(const FramePair& pair, std::span<Image* const> out) noexcept;
  void steer_exposure(std::span<Image* const> out) noexcept;
  void fill_status(const FramePair* pair) noexcept;
  Reason why_none() noexcept;

  const Config& config_;
  std::vector<std::unique_ptr<CameraFeed>> feeds_;
  std::optional<Calibration> calibration_;
  ImageSpec spec_{};

  mutable std::mutex mutex_;  // of all below, up to the next empty line
  std::condition_variable changed_;
  std::vector<Slot> slots_;
  FramePairs pairs_;
  std::optional<FramePair> ready_;
  uint64_t pairs_count_ = 0, skipped_ = 0;
  int64_t last_pair_ns_ = 0;
  bool settled_ = false;  // spec_ is chosen
  bool stopping_ = false;

  std::atomic<bool> exchanged_{false};
  bool order_known_ = true;
  int64_t turned_ns_ = INT64_MIN;  // when the views of later frames were exchanged
  int64_t period_ns_ = 0;          // of the slower camera
  ViewOrder order_;
  std::optional<FloorExposure> exposure_;
  CameraStatus status_{};
  std::string fault_;
  std::deque<std::string> news_;
  std::vector<std::thread> triggers_;
};

}  // namespace vdisp
