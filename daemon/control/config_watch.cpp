// config_watch.cpp: eventfd, signalfd and inotify in one poll().
// SPDX-License-Identifier: Apache-2.0
#include "daemon/control/config_watch.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/inotify.h>
#include <sys/signalfd.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cstring>

#include "daemon/core/clock.h"

namespace vdisp {
namespace {

namespace fs = std::filesystem;

constexpr int64_t ms = 1'000'000;
constexpr int64_t quiet_ns = 200 * ms;     // an editor is done when it has been quiet for so long
constexpr int64_t longest_ns = 1000 * ms;  // who writes all the time is looked at all the same
constexpr int64_t look_ns = 1000 * ms;     // for a folder that is not there

sigset_t hangup_set() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGHUP);
  return set;
}

/// A file that was just created is written yet, but for a link, which is whole from the start.
bool whole_when_created(const fs::path& file) {
  struct stat found {};
  return lstat(file.c_str(), &found) == 0 && (S_ISLNK(found.st_mode) || found.st_nlink > 1);
}

}  // namespace

void ConfigWatch::hold_hangup() {
  const sigset_t set = hangup_set();
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
}

ConfigWatch::ConfigWatch(fs::path file, bool changes) : file_(std::move(file)) {
  const sigset_t set = hangup_set();
  asked_ = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
  signals_ = signalfd(-1, &set, SFD_NONBLOCK | SFD_CLOEXEC);
  if (file_.empty() || !changes) return;
  std::error_code ignored;
  file_ = fs::absolute(file_, ignored);
  changes_ = inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
  if (changes_ < 0) {
    trouble_ = file_.string() + ": changes are not seen (inotify: " + std::strerror(errno) + "); SIGHUP has it read again";
  } else {
    place_watches();
  }
}

ConfigWatch::~ConfigWatch() {
  for (int file : {asked_, signals_, changes_})
    if (file >= 0) close(file);
}

void ConfigWatch::ask() noexcept {
  const uint64_t one = 1;
  if (write(asked_, &one, sizeof one) < 0) return;  // full: it is readable all the same
}

/// Folders are watched, not the file: the file that is put in its place is another one.
void ConfigWatch::place_watches() {
  std::error_code error;
  const fs::path real = fs::canonical(file_, error);
  const fs::path wanted[] = {file_, error ? file_ : real};
  all_placed_ = true;
  for (size_t i = 0; i < places_.size(); ++i) {
    constexpr uint32_t events =
        IN_CLOSE_WRITE | IN_MOVED_TO | IN_MOVED_FROM | IN_CREATE | IN_DELETE | IN_DELETE_SELF | IN_MOVE_SELF | IN_ONLYDIR;
    const int descriptor = inotify_add_watch(changes_, wanted[i].parent_path().c_str(), events);
    if (places_[i].descriptor >= 0 && places_[i].descriptor != descriptor && places_[0].descriptor != places_[1].descriptor)
      inotify_rm_watch(changes_, places_[i].descriptor);
    places_[i] = {wanted[i].parent_path(), wanted[i].filename().string(), descriptor};
    all_placed_ = all_placed_ && descriptor >= 0;
  }
}

/// True: the file may be another one now.
bool ConfigWatch::take_changes() {
  alignas(inotify_event) char bytes[16 * (sizeof(inotify_event) + NAME_MAX + 1)];
  bool ours = false;
  for (ssize_t size; (size = read(changes_, bytes, sizeof bytes)) > 0;) {
    for (ssize_t at = 0; at < size;) {
      const auto& event = *reinterpret_cast<const inotify_event*>(bytes + at);
      at += static_cast<ssize_t>(sizeof event + event.len);
      if (event.mask & (IN_Q_OVERFLOW | IN_DELETE_SELF | IN_MOVE_SELF | IN_IGNORED)) ours = true;
      for (const Place& place : places_) {
        if (event.wd != place.descriptor || event.len == 0 || place.name != event.name) continue;
        if (!(event.mask & IN_CREATE) || whole_when_created(place.folder / place.name)) ours = true;
      }
    }
  }
  return ours;
}

/// When a change is old enough to be told, or a folder is to be looked for; INT64_MAX: never.
int64_t ConfigWatch::next_look_ns(int64_t now_ns) const {
  if (first_change_ns_ != 0) return std::min(last_change_ns_ + quiet_ns, first_change_ns_ + longest_ns);
  return changes_ >= 0 && !all_placed_ ? now_ns + look_ns : INT64_MAX;
}

ConfigWatch::Event ConfigWatch::wait(int limit_ms) {
  const int64_t end = monotonic_ns() + limit_ms * ms;
  while (true) {
    const int64_t now = monotonic_ns(), look = next_look_ns(now);
    pollfd files[] = {{asked_, POLLIN, 0}, {signals_, POLLIN, 0}, {changes_, POLLIN, 0}};
    const int64_t left = std::clamp<int64_t>((std::min(look, end) - now + ms - 1) / ms, 0, limit_ms);
    const int found = poll(files, 3, static_cast<int>(left));
    if (found < 0 && errno != EINTR) return Event::nothing;
    uint64_t count = 0;
    if (found > 0 && files[0].revents && read(asked_, &count, sizeof count) == sizeof count) return Event::asked;
    signalfd_siginfo signal{};
    if (found > 0 && files[1].revents && read(signals_, &signal, sizeof signal) == sizeof signal) {
      if (signal.ssi_code == SI_KERNEL) {  // the terminal is gone that vdispd was started from
        kill(getpid(), SIGTERM);
        return Event::nothing;
      }
      pid_ = static_cast<pid_t>(signal.ssi_pid);
      uid_ = signal.ssi_uid;
      return Event::hangup;
    }
    if (found > 0 && files[2].revents && take_changes()) {
      last_change_ns_ = monotonic_ns();
      if (first_change_ns_ == 0) first_change_ns_ = last_change_ns_;
    }
    const int64_t then = monotonic_ns();
    if (then >= look) {
      const bool told = first_change_ns_ != 0 && next_look_ns(then) <= then;
      const bool missing = !all_placed_;
      if (told || missing) place_watches();
      if (told) first_change_ns_ = 0;
      if (told || (missing && all_placed_)) return Event::changed;
    }
    if (then >= end) return Event::nothing;
  }
}

}  // namespace vdisp
