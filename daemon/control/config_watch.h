// config_watch.h: when vdisp.cfg is to be read again: a signal, a changed file; and when somebody asks for something.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>

namespace vdisp {

/// All in one wait, for one thread. A file is changed when it was written and closed, or another one was put in its place, as editors do,
/// and nothing more has happened to it for a moment; links are followed.
class ConfigWatch {
 public:
  enum class Event { nothing, asked, hangup, changed };

  /// From here on SIGHUP ends no thread of this process and waits to be taken. Before the first thread is started. That of the kernel, when
  /// a terminal is lost, becomes SIGTERM.
  static void hold_hangup();

  /// `file`: empty: none. `changes`: whether it is watched.
  ConfigWatch(std::filesystem::path file, bool changes);
  ~ConfigWatch();
  ConfigWatch(const ConfigWatch&) = delete;
  ConfigWatch& operator=(const ConfigWatch&) = delete;

  /// Ends a wait with `asked`; any thread, no wait. Several may end one.
  void ask() noexcept;
  /// The next event, `nothing` at the limit.
  Event wait(int limit_ms);
  /// Who sent the signal last.
  pid_t pid() const { return pid_; }
  uid_t uid() const { return uid_; }
  /// Why changes are not seen, in one line; empty: they are, or need not be.
  const std::string& trouble() const { return trouble_; }

 private:
  struct Place {
    std::filesystem::path folder;
    std::string name;
    int descriptor = -1;
  };
  void place_watches();
  bool take_changes();
  int64_t next_look_ns(int64_t now_ns) const;

  std::filesystem::path file_;
  int asked_ = -1, signals_ = -1, changes_ = -1;
  std::array<Place, 2> places_;  // of the name, and of what it is a link to
  bool all_placed_ = true;
  int64_t first_change_ns_ = 0, last_change_ns_ = 0;  // not told yet; 0: none
  pid_t pid_ = 0;
  uid_t uid_ = 0;
  std::string trouble_;
};

}  // namespace vdisp
