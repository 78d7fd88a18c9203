// report.h: says what happens: a line on each edge, and the state once a second for programs.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "daemon/tools/drive/motors.h"
#include "daemon/tools/drive/orders.h"

namespace vdisp::drive {

class Report {
 public:
  /// `json`: a line on standard output once a second and on each edge.
  explicit Report(bool json) : json_(json) {}
  /// After each Motors::serve().
  void see(const Motors& motors, const Order& order, Orders& orders, int64_t now_ns);
  /// The last lines.
  void finish(const Motors& motors, int64_t now_ns);

 private:
  /// What makes a state another one.
  struct State {
    Halt halt = Halt::count;  // nothing told yet
    Connection connection = Connection::connected;
    Reason reason = Reason::none;
    bool not_published = false;
    std::string fault;
    bool operator==(const State&) const = default;
  };
  State state(const Motors& motors, const Order& order, Orders& orders, int64_t now_ns);
  static std::string why(const Motors& motors, const Order& order, Orders& orders);
  void tell(int64_t now_ns);
  void write_json(const Motors& motors, const Order& order, uint64_t reconnections, int64_t now_ns);

  bool json_;
  State now_, told_;
  std::string why_;  // they stand, or stood last
  uint64_t untold_ = 0, opened_ = 0, skipped_ = 0;
  int64_t told_ns_ = 0, since_ns_ = 0, driven_ns_ = 0, asked_ns_ = 0, written_ns_ = 0;
  Halt written_ = Halt::count;
};

}  // namespace vdisp::drive
