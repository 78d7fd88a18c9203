// asked_flight.h: which of the flight recorder's folders is the one that was asked for, and what became of it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "ipc/records.h"

namespace vdisp {

/// Looks at `recorder`, from before the order on. Folders are written one after the other; meanwhile others may ask and other things
/// happen, and an order that comes while another cause waits already is joined to it.
class AskedFlight {
 public:
  enum class State {
    awaited,
    writing,
    written,
    failed,
    overtaken  ///< done, and so is a later one: what was told of ours was not seen
  };

  explicit AskedFlight(const RecorderStatus& before) : last_(before), begun_before_(before.asked) {}
  /// What the daemon tells after a step, not of each of them.
  State see(const RecorderStatus& now);
  /// The folder, or why it could not be written.
  std::string text() const;

 private:
  RecorderStatus last_;
  uint64_t begun_before_;
  uint64_t number_ = 0;         // of ours, among all that were begun; 0: not known yet
  int idle_ = 0;                // looks in a row at which nothing was being written
  bool newest_failed_ = false;  // of those that are done
};

}  // namespace vdisp
