// source.h: what the tree and the loop need to know of a stereo source besides its images; open_source() picks one.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include "config/config.h"
#include "daemon/core/driver.h"
#include "daemon/geometry/calibration.h"
#include "ipc/recorded_step.h"
#include "ipc/records.h"

namespace vdisp {

/// Makes two images, left and right, gray8 of one size, raw as the cameras see them.
class StereoSource : public ImageSource {
 public:
  /// Empty: images are taken as rectified and there are no metres.
  virtual std::optional<Calibration> calibration() const = 0;
  /// From frame to frame; 0: as fast as possible.
  virtual int64_t period_ns() const = 0;
  /// At which the next pair comes, whether it is waited for or not; 0: not known, or when this one is done.
  virtual int64_t pair_period_ns() const { return period_ns(); }
  /// Where the last pair came from, left and right, for the dump; empty where images have no names.
  virtual std::pair<std::string, std::string> files() const { return {}; }
  /// What was wrong with the last pair, or why a recording ended early: file and what, in one line. Empty where nothing was.
  /// Valid until the next grab(); a good pair costs no allocation.
  virtual std::string_view fault() const noexcept { return {}; }
  /// Waits at most that long for the next pair. True: a step makes sense: there is one, or its time is over. Not from grab().
  virtual bool wait(int) noexcept { return true; }
  /// Lets go of what others may want at once, cameras that is. No grab() after it.
  virtual void close() noexcept {}
  /// What the cameras deliver, where there are any; valid until the next grab(). Header not filled in.
  virtual const CameraStatus* cameras() const noexcept { return nullptr; }
  /// A line that the operator should read: a camera opened, lost, back. False: there is none.
  virtual bool news(std::string&) { return false; }
  /// A simulated robot has run into something since the last call.
  virtual bool bumped() noexcept { return false; }
  /// Where the rover was when the last pair was taken, for a source that knows: from open() on never null then, x NaN where this pair has
  /// no pose. Header, age and tally are not filled in.
  virtual const Odometry* odometry() const noexcept { return nullptr; }
  /// What its IMU told when the last pair was taken, likewise.
  virtual const Imu* imu() const noexcept { return nullptr; }
  /// A recording that tells all that came in at the last step, times and blindness included: from open() on never null then.
  virtual const RecordedStep* recorded() const noexcept { return nullptr; }
  /// The number that the next frame had when it was recorded; empty: they are counted from 0.
  virtual std::optional<uint64_t> next_sequence() const noexcept { return {}; }
  /// Whether it takes the tree's last drive command (ImageSource::heeds), as a simulated robot does.
  bool driven() const { return !heeds().empty(); }
  /// Adds the stages truth/..., where the source knows the truth. `camera` is the left image.
  virtual void add_truth(Driver&, Handle) {}
};

/// exit_code: 66 no input, 69 no camera, 78 wrong configuration or calibration. One line: what was found, where, what would be right.
class SourceError : public std::runtime_error {
 public:
  SourceError(int code, const std::string& what) : std::runtime_error(what), exit_code(code) {}
  int exit_code;
};

/// The source that [image source] source names. Throws SourceError or CalibrationError.
std::unique_ptr<StereoSource> open_source(const Config& config);

}  // namespace vdisp
