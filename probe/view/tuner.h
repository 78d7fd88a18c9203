// tuner.h: the live parameters of the stage that is shown, and what the operator does to them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "probe/view/conversation.h"
#include "probe/view/panel.h"

namespace vdisp {

/// True where the parameter is one to turn while the stage is looked at. Of a stage that is not known every one is.
bool concerns(std::string_view topic, std::string_view key);

/// Talks to the control socket and waits for nothing: what is turned shows at once what it was turned to, and goes back where the daemon
/// says no. A limit of some seconds, as the daemon takes a frame or two for each 16 parameters.
class Tuner {
 public:
  explicit Tuner(const std::string& control, std::chrono::milliseconds limit = std::chrono::milliseconds(5000)) : talk_(control, limit) {}

  /// What the window draws; closed until open().
  const Panel& panel() const { return panel_; }
  void open(bool on);
  /// Only those of this stage, unless all are shown.
  void show(std::string_view topic);
  void show_all(bool on);
  void choose(int by);
  void step(int by);
  /// The mouse takes slider `index` at 0 to 1 of its way, and drags it. Until let_go() all of it is one step for undo.
  void press(size_t index, double place);
  void drag(double place);
  void let_go() { dragging_ = false; }
  bool dragging() const { return dragging_; }
  void undo();
  void save();
  /// What the daemon has answered. Nothing: no answer came; else what became of undo or save in one line, or empty.
  std::optional<std::string> hear();
  /// The generation of the image shown: where somebody else has changed a parameter, all are asked for anew.
  void follow(uint64_t config_generation);

 private:
  void ask();
  void pick();
  void set(Slider& slider, const std::string& value, bool joined);
  std::string take(const WishAnswer& answer);
  void take_all(const WishAnswer& answer);
  void take_set(const WishAnswer& answer);
  /// Sliders show again what the daemon has: all of them, or that of one key.
  void settle(const std::string& key = {});

  Conversation talk_;
  std::vector<Slider> all_;  // as the daemon has them
  Panel panel_;
  std::string topic_;
  uint64_t generation_ = 0;
  bool everything_ = false, dragging_ = false;
  bool joined_ = false;  // the slider that is dragged was set already
  int sets_ = 0;         // that are not answered yet
};

}  // namespace vdisp
