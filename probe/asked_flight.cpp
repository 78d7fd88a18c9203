// asked_flight.cpp: folders are numbered as they are begun (`asked`), and are done (`written`, `failed`) in that order.
// SPDX-License-Identifier: Apache-2.0
#include "probe/asked_flight.h"

#include <cstring>

namespace vdisp {
namespace {

// An order is heard in the next step, its folder is begun at the end of it, and told in the one after.
constexpr int heard_by_then = 4;

}  // namespace

std::string AskedFlight::text() const { return {last_.text, strnlen(last_.text, sizeof last_.text)}; }

AskedFlight::State AskedFlight::see(const RecorderStatus& now) {
  const bool failed = now.failed > last_.failed, written = now.written > last_.written;
  last_ = now;
  // Both since the last look: a folder's name is told without a colon and what was wrong with it.
  if (failed || written) newest_failed_ = failed && (!written || text().find(": ") != std::string::npos);
  idle_ = now.writing ? 0 : idle_ + 1;
  // One that was begun meanwhile for another cause is followed by ours at once; where none follows, the order was joined to it.
  if (number_ == 0 && now.asked > begun_before_ && (now.cause == FlightCause::asked || idle_ >= heard_by_then)) number_ = now.asked;
  if (number_ == 0) return State::awaited;
  const uint64_t done = now.written + now.failed;
  if (done < number_) return State::writing;
  if (done > number_) return State::overtaken;
  return newest_failed_ ? State::failed : State::written;
}

}  // namespace vdisp
