// quiet.h: keeps iceoryx from printing and from aborting the process it lives in.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace vdisp {

/// Turns off iceoryx's logging, and drops what its own threads write to cout, clog and cerr. Other threads print as before.
void silence_iceoryx();

enum class Who { this_thread, everybody };

/// While one exists, what is written to cout, clog and cerr is dropped: iceoryx prints from the calling thread too, and from
/// threads of its own before they have their names.
class Muted {
 public:
  explicit Muted(Who who = Who::this_thread);
  ~Muted();
  Muted(const Muted&) = delete;
  Muted& operator=(const Muted&) = delete;

 private:
  Who who_;
};

/// In the daemon: a fatal error of iceoryx is one line on stderr and _exit: 69, 71 or 77 where it is known, else 75.
void exit_on_fatal_error();
/// In a client: no error ends the process; errors are counted, and the client gives up its connection when the count changes.
void count_errors();
uint64_t counted_errors();

}  // namespace vdisp
