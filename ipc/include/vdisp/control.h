// control.h: tells vdispd where the rover is and what happens to it, and sets its parameters; C in control_c.h.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "vdisp/command.h"

namespace vdisp {

inline constexpr double not_known = std::numeric_limits<double>::quiet_NaN();

/// Stamps are CLOCK_MONOTONIC in ns, of the measurement; 0: now.
/// In the odometry frame (REP-103: x forward, y left, z up at its start), m and rad, yaw positive to the left.
struct OdometrySample {
  int64_t timestamp_ns = 0;
  double x = 0, y = 0, yaw = 0;
  double z = not_known, roll = not_known, pitch = not_known;  ///< positive: right side low, nose down
  double speed = not_known, turn_rate = not_known;            ///< m/s ahead, rad/s to the left
  double position_deviation = not_known, yaw_deviation = not_known;
};

/// In the rover frame: x forward, y left, z up.
struct ImuSample {
  int64_t timestamp_ns = 0;
  double acceleration[3] = {0, 0, 0};  ///< m/s^2; at rest it points up: (0, 0, 9.81) on level ground
  double rate[3] = {not_known, not_known, not_known};
};

struct ParameterInfo {
  std::string key;  ///< SECTION.KEY
  std::string value, standard, allowed, unit, help;
  bool live = false;               ///< may be set in a running daemon
  uint64_t config_generation = 0;  ///< how many times the configuration was changed since the daemon started
  uint64_t sequence = 0;           ///< the first frame with this value
};

/// One connection to the daemon's control socket; not thread-safe. It connects by itself, again after the daemon was started anew.
/// No call throws or waits longer than its time limit.
class Control {
 public:
  enum class Result {
    done,
    refused,        ///< the daemon says no: message() tells why, and nothing was changed (78)
    unknown,        ///< no such key (64)
    needs_restart,  ///< the key takes effect at the next start only (78)
    failed,         ///< save: the file cannot be written (73)
    no_daemon,      ///< nothing listens there (69)
    no_permission,  ///< not a member of [ipc] group (77)
    busy,           ///< all connections of the daemon are in use, or it does not take what is sent (69)
    no_answer,      ///< the time limit passed (69)
    wrong_version,  ///< daemon and library do not belong together (69)
  };

  /// `path`: the socket; empty: /run/vdisp/control, or vdisp/control under $XDG_RUNTIME_DIR where that one is not.
  explicit Control(std::string path = {}, std::chrono::milliseconds limit = std::chrono::milliseconds(2000));
  ~Control();
  Control(const Control&) = delete;
  Control& operator=(const Control&) = delete;

  /// Sent and not answered: what became of it stands in in/odometry, in/imu, in/drive and in/event (InputTally).
  Result odometry(const OdometrySample& sample);
  Result imu(const ImuSample& sample);
  Result drive(double speed, double turn_rate, int64_t timestamp_ns = 0);
  /// 1 to 47 printable characters.
  Result event(std::string_view label, int64_t timestamp_ns = 0);

  /// `key`: SECTION.KEY, or KEY where one section has it. `info` tells what holds now.
  Result set(std::string_view key, std::string_view value, ParameterInfo* info = nullptr);
  /// As set(), for a slider that moves: with the set() or adjust() of the same key before, by this connection, it is one step for undo().
  Result adjust(std::string_view key, std::string_view value, ParameterInfo* info = nullptr);
  Result get(std::string_view key, ParameterInfo& info);
  /// All, in the order of vdisp.cfg. The daemon takes a frame or two for each 16 of them: a limit of some seconds is right.
  Result get_all(std::vector<ParameterInfo>& all);
  /// Takes the last set back.
  Result undo(ParameterInfo* info = nullptr);
  /// Writes what was set into the vdisp.cfg that the daemon was started with. message() tells the file.
  Result save();

  /// Of the last call, in one line: what was found, and what would be right. After save() also where it wrote.
  const std::string& message() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// The exit code that goes with it (sysexits.h).
int exit_code(Control::Result result);

}  // namespace vdisp
