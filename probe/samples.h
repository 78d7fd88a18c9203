// samples.h: what the words that talk to the daemon share: trying until it is there, and lines of CSV as samples.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "ipc/include/vdisp/control.h"
#include "probe/words.h"

namespace vdisp {

/// The limit of a connection for Control::get_all().
inline constexpr std::chrono::seconds limit_of_all{10};

/// Calls until the daemon is there, at most options.wait_s. Throws ProbeError with the exit code of what went wrong.
void require_done(const Control& control, const Options& options, const std::function<Control::Result()>& call);

/// Lines of one kind. The first line may name the columns, in any order; else they are, as many as there are:
/// odometry x,y,yaw,z,roll,pitch,speed,turn_rate; imu ax,ay,az,wx,wy,wz; drive speed,turn_rate; event label.
/// A column timestamp_ns says when a line was measured.
class Samples {
 public:
  explicit Samples(std::string kind);

  struct Line {
    std::optional<int64_t> timestamp_ns;
    std::vector<double> values;  ///< in the order above, NaN where the line has none
    std::string label;           ///< of an event
  };
  /// Nothing for what is no sample: blank lines, comments (#), names of columns. Throws ProbeError (66) naming the line.
  std::optional<Line> read(const std::string& line);
  Control::Result send(Control& control, const Line& line, int64_t timestamp_ns) const;

 private:
  bool take_names(const std::vector<std::string>& fields);

  std::string kind_;
  std::vector<std::string> known_;    // columns of this kind
  std::vector<std::string> columns_;  // of the lines
  size_t needed_ = 0;                 // the first so many must be there
  int count_ = 0;                     // lines read
  bool first_ = true;
};

}  // namespace vdisp
