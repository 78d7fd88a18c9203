// dc1394_camera.h: one camera on the FireWire bus, by libdc1394.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <dc1394/dc1394.h>

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

#include "config/config.h"
#include "daemon/sources/camera.h"

namespace vdisp {

/// Makers' number of Videre Design, the upper 24 bits of a GUID.
inline constexpr uint64_t videre_vendor = 0x5505;

struct FreeBus {
  void operator()(dc1394_t* bus) const { dc1394_free(bus); }
};
using Dc1394Bus = std::unique_ptr<dc1394_t, FreeBus>;
/// The bus, its library's own messages silenced; null: there is none, or it may not be opened.
Dc1394Bus open_dc1394_bus();
std::string guid_text(uint64_t guid);
/// What the permissions of /dev/fw* say where nothing is found; empty: nothing is wrong with them.
std::string dc1394_denied();

class Dc1394Camera final : public Camera {
 public:
  /// The configuration must outlive the camera.
  Dc1394Camera(uint64_t guid, const Config& config);
  ~Dc1394Camera() override { Dc1394Camera::close(); }

  const std::string& name() const override { return name_; }
  FrameFormat open() override;
  Delivery wait(int timeout_ms, RawFrame& frame) noexcept override;
  void release(const RawFrame& frame) noexcept override;
  void close() noexcept override;
  std::string_view problem() const noexcept override { return problem_; }
  void trigger() noexcept override;
  bool expose(double exposure_us, double gain_db) noexcept override;
  double longest_exposure() const noexcept override { return longest_exposure_us_; }
  double highest_gain() const noexcept override { return highest_gain_db_; }
  std::string stored_calibration() override;

 private:
  [[noreturn]] void refuse(CameraFault fault, const std::string& what);
  void must(dc1394error_t done, const char* what);
  dc1394video_mode_t choose_mode(FrameFormat& format);
  void choose_rate(dc1394video_mode_t mode, FrameFormat& format);
  void check_colour();
  void prepare_trigger();
  void prepare_exposure();
  bool set_feature(dc1394feature_t feature, double value, double period_value) noexcept;
  bool videre() const { return camera_->guid >> 40 == videre_vendor; }

  const uint64_t guid_;
  const Config& config_;
  std::string name_, problem_;
  Dc1394Bus bus_;
  dc1394camera_t* camera_ = nullptr;
  std::mutex features_;  ///< exposure against trigger: one transaction at a time
  bool capturing_ = false;
  uint64_t count_ = 0;
  double period_s_ = 0, exposure_us_ = 0, longest_exposure_us_ = 0, highest_gain_db_ = 0;
};

}  // namespace vdisp
