// camera.h: one physical camera as a driver gives it: opened, waited on, closed, any number of times, by one thread.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>

namespace vdisp {

constexpr double default_trigger_rate = 30;  ///< Hz, where `trigger` is software and `rate` is 0

/// What the bytes of a frame are. Words of more than 8 bits are little-endian, their value in the low bits.
enum class FramePixels : uint8_t { gray8, gray10, gray12, gray16, bayer8, rgb8, bgr8, yuyv, uyvy, jpeg };

/// Which views a frame holds: one, both beside each other, or both with their bytes by turns (STH-MDCS2: a view's pixel each).
enum class FrameViews : uint8_t { one, beside, by_turns };

struct FrameFormat {
  FramePixels pixels = FramePixels::gray8;
  FrameViews views = FrameViews::one;
  int width = 0, height = 0;  ///< px of one view
  ptrdiff_t stride = 0;       ///< bytes from row to row of the frame; not for jpeg
  std::string bayer;          ///< "rggb", ... where pixels are bayer8 and the camera tells its mosaic
  double period_s = 0;        ///< from frame to frame; 0: the camera does not tell
  /// As open() set them; NaN: left to the camera, or it has none.
  double exposure_us = std::numeric_limits<double>::quiet_NaN(), gain_db = std::numeric_limits<double>::quiet_NaN();
};

/// A frame in the driver's buffer, until release().
struct RawFrame {
  const std::byte* bytes = nullptr;
  size_t size = 0;
  int64_t camera_ns = -1;   ///< middle of the exposure by the camera's clock; -1: it has none
  int64_t arrival_ns = 0;   ///< CLOCK_MONOTONIC when all of it was there
  int64_t delay_ns = 0;     ///< the middle of the exposure was at least that long before the arrival
  int64_t exposed_ns = -1;  ///< middle of the exposure in CLOCK_MONOTONIC, where the driver tells it; then camera_ns is not looked at
  uint64_t count = 0;       ///< the camera's own number of the frame; it goes on over lost ones
  int64_t buffer = 0;       ///< the driver's
};

/// frame: there is one; nothing: not in time; incomplete: there was one, but parts are missing; lost: the camera is gone, close() it.
enum class Delivery : uint8_t { frame, nothing, incomplete, lost };

/// Why a camera does not open. absent and busy heal by waiting; denied and unsupported do not.
enum class CameraFault : uint8_t { absent, busy, denied, unsupported, failed };

/// One line: what was found, at which camera, what would be right.
class CameraError : public std::runtime_error {
 public:
  CameraError(CameraFault why, const std::string& what) : std::runtime_error(what), fault(why) {}
  CameraFault fault;
};

class Camera {
 public:
  virtual ~Camera() = default;
  Camera() = default;
  Camera(const Camera&) = delete;
  Camera& operator=(const Camera&) = delete;

  /// For messages, with kind and which: "GigE camera LEFT01".
  virtual const std::string& name() const = 0;
  /// Opens and starts it; after a close() the same camera only: by serial number or GUID where the bus has one; Video4Linux2 has none,
  /// there it is another one of the same name in the same port too. May take seconds. Throws CameraError.
  virtual FrameFormat open() = 0;
  /// Frames come in the order they were taken; of those that wait the newest is enough. What is wrong is in `problem()`.
  virtual Delivery wait(int timeout_ms, RawFrame& frame) noexcept = 0;
  virtual void release(const RawFrame& frame) noexcept = 0;
  virtual void close() noexcept = 0;
  /// What was incomplete or why it is lost, in a few words; valid until the next wait().
  virtual std::string_view problem() const noexcept { return {}; }

  /// Asks for a frame, where `trigger` is software. Called for all cameras of a pair one right after the other.
  virtual void trigger() noexcept {}
  /// Sets exposure (us) and gain (dB) from the next frames on. False: it cannot.
  virtual bool expose(double, double) noexcept { return false; }
  /// Longest exposure (us) and highest gain (dB) that expose() takes; 0: not known.
  virtual double longest_exposure() const noexcept { return 0; }
  virtual double highest_gain() const noexcept { return 0; }
  /// A calibration file that the camera carries in its memory; empty: none.
  virtual std::string stored_calibration() { return {}; }
};

}  // namespace vdisp
