// v4l2_camera.h: one device of Video4Linux2.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <linux/videodev2.h>

#include <cstdint>
#include <string>
#include <vector>

#include "config/config.h"
#include "daemon/sources/v4l2.h"

namespace vdisp {

/// Linux tells neither gain nor its unit: the range of a camera's gain control is taken for 0 to so many dB.
inline constexpr double v4l2_gain_range_db = 24;

class V4l2Camera final : public Camera {
 public:
  /// `device`: path of the device node, or a link to it. Configuration and system must outlive the camera.
  V4l2Camera(V4l2System& system, std::string device, const Config& config);
  ~V4l2Camera() override { V4l2Camera::close(); }

  const std::string& name() const override { return name_; }
  FrameFormat open() override;
  Delivery wait(int timeout_ms, RawFrame& frame) noexcept override;
  void release(const RawFrame& frame) noexcept override;
  void close() noexcept override;
  std::string_view problem() const noexcept override { return problem_; }
  bool expose(double exposure_us, double gain_db) noexcept override;
  double longest_exposure() const noexcept override { return longest_exposure_us_; }
  double highest_gain() const noexcept override { return gain_most_ > gain_least_ ? v4l2_gain_range_db : 0; }

 private:
  struct Buffer {
    void* memory = nullptr;
    size_t bytes = 0;
  };
  [[noreturn]] void refuse(CameraFault fault, const std::string& what);
  [[noreturn]] void refuse_open(int error);
  void open_device();
  void same_camera_only(const v4l2_capability& capability);
  v4l2_format choose_format(FrameFormat& format);
  std::vector<uint32_t> offered();
  std::string sizes_of(uint32_t pixels);
  void set_rate(FrameFormat& format);
  void prepare_exposure();
  void start_stream();
  bool set(uint32_t control, int value) noexcept;
  bool range(uint32_t control, int& least, int& most) noexcept;
  int64_t exposed_ns(const v4l2_buffer& buffer) const noexcept;

  V4l2System& system_;
  const Config& config_;
  std::string device_, name_, card_, bus_, problem_;
  int file_ = -1;
  bool streaming_ = false;
  std::vector<Buffer> buffers_;
  double exposure_us_ = 0, longest_exposure_us_ = 0;  ///< as last set; 0: not known
  int gain_least_ = 0, gain_most_ = 0;
};

}  // namespace vdisp
