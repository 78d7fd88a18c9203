// upkeep.h: what the loop does beside its frames: control socket, health, recordings, systemd.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "daemon/control/command_socket.h"
#include "daemon/health_report.h"
#include "daemon/recorder.h"
#include "daemon/service/service.h"

namespace vdisp {

/// The loop's: between two frames it hears what is asked, and after each it tells how things are. Begun in the order of its functions.
class Upkeep {
 public:
  /// Adds its own stage, the last one, to the tree. What is given must outlive it.
  Upkeep(Driver& driver, Config& config, StereoSource& source, Inputs& inputs);
  /// When the tree is published. `record`: the folder of --record, empty: none. `serves`: readers may come, so what is asked is heard.
  /// `attachable`: Service's. Throws WriteError and ControlError.
  void begin(const ConfigOrigin& origin, const std::string& record, uint64_t epoch, bool serves, std::function<bool()> attachable);

  /// What came by the control socket, in vdisp.cfg, or by SIGUSR1 (`flight_asked`), between two frames. No wait, no allocation.
  void serve(bool flight_asked);
  /// Each image of a step, before it is published.
  void see(const Topic& topic, const Image& image) noexcept;
  /// After each step. Throws WriteError where --record cannot go on.
  void stepped(Outcome outcome);
  /// systemd hears that the daemon ends.
  void stopping() { service_->stopping(); }
  /// Writes what recordings still hold; ends threads, closes sockets. Throws WriteError.
  void finish();

  /// From one step to the next, at least.
  int64_t period_ns() const;

 private:
  Driver& driver_;
  Config& config_;
  StereoSource& source_;
  Inputs& inputs_;
  Recorder recorder_;
  std::optional<CommandSocket> control_;
  std::optional<HealthReport> report_;
  std::optional<Service> service_;
};

}  // namespace vdisp
