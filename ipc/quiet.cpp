// quiet.cpp: iceoryx's logger, streams and error handler.
// SPDX-License-Identifier: Apache-2.0
#include "ipc/quiet.h"

#include <pthread.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstdio>
#include <cstring>
#include <iceoryx_hoofs/error_handling/error_handling.hpp>
#include <iceoryx_hoofs/log/logmanager.hpp>
#include <iostream>
#include <string_view>

namespace vdisp {
namespace {

thread_local int muted = 0;
std::atomic<int> everybody_muted{0};
std::atomic<uint64_t> errors{0};

bool iceoryx_thread() {
  constexpr std::array<std::string_view, 6> names{"Mon+Discover", "IPC-msg-process", "KeepAlive", "ProcessIntr", "MemPoolIntr", "PortIntr"};
  char name[16] = {};
  pthread_getname_np(pthread_self(), name, sizeof name);
  for (std::string_view known : names) {
    if (known == name) return true;
  }
  return false;
}

/// RouDi says on cout that it is ready and on cerr that a client is gone; there is no switch for either.
class Filter final : public std::streambuf {
 public:
  explicit Filter(std::ostream& stream) : behind_(stream.rdbuf(this)) {}

 private:
  static bool dropped() { return muted > 0 || everybody_muted > 0 || iceoryx_thread(); }
  int overflow(int c) override { return dropped() || c == EOF ? 0 : behind_->sputc(static_cast<char>(c)); }
  std::streamsize xsputn(const char* text, std::streamsize size) override { return dropped() ? size : behind_->sputn(text, size); }
  int sync() override { return dropped() ? 0 : behind_->pubsync(); }

  std::streambuf* behind_;
};

// Never destroyed: iceoryx's threads write until the process is gone, and the guard would put the aborting handler back.
[[gnu::used]] std::array<Filter, 3>* filters = nullptr;
[[gnu::used]] iox::cxx::GenericRAII* handler_guard = nullptr;

int exit_code_of(iox::Error error) {
  switch (error) {
    case iox::Error::kICEORYX_ROUDI_MEMORY_MANAGER__ROUDI_STILL_RUNNING:
    case iox::Error::kIPC_INTERFACE__APP_WITH_SAME_NAME_STILL_RUNNING: return 69;
    case iox::Error::kROUDI_COMPONENTS__SHARED_MEMORY_UNAVAILABLE:
    case iox::Error::kMEPOO__SEGMENT_UNABLE_TO_CREATE_SHARED_MEMORY_OBJECT: return 71;
    case iox::Error::kICEORYX_ROUDI_MEMORY_MANAGER__COULD_NOT_ACQUIRE_FILE_LOCK:
    case iox::Error::kIPC_INTERFACE__COULD_NOT_ACQUIRE_FILE_LOCK:
    case iox::Error::kIPC_INTERFACE__UNABLE_TO_CREATE_APPLICATION_CHANNEL:
    case iox::Error::kMEPOO__SEGMENT_COULD_NOT_APPLY_POSIX_RIGHTS_TO_SHARED_MEMORY: return 77;
    default: return 75;
  }
}

void die(iox::Error error) {
  const int code = exit_code_of(error);
  const char* advice = code == 69   ? "another RouDi is running; one vdispd per machine"
                       : code == 71 ? "/dev/shm has no room, or refuses it"
                       : code == 77 ? "/tmp or /dev/shm cannot be written, or holds files of another user"
                                    : "this is a bug, here or in iceoryx";
  char line[300];
  const int size =
      std::snprintf(line, sizeof line, "shared memory: iceoryx gave up with %s: %s\n", iox::ErrorHandler::toString(error), advice);
  if (write(STDERR_FILENO, line, static_cast<size_t>(size)) < 0) { /* nobody to tell */
  }
  _exit(code);
}

void install(const iox::HandlerFunction& handler) {
  if (!handler_guard) handler_guard = new iox::cxx::GenericRAII(iox::ErrorHandler::setTemporaryErrorHandler(handler));
}

}  // namespace

void silence_iceoryx() {
  iox::log::LogManager::GetLogManager().SetDefaultLogLevel(iox::log::LogLevel::kOff, iox::log::LogLevelOutput::kHideLogLevel);
  if (!filters) filters = new std::array<Filter, 3>{Filter(std::cout), Filter(std::clog), Filter(std::cerr)};
}

Muted::Muted(Who who) : who_(who) {
  ++muted;
  if (who_ == Who::everybody) ++everybody_muted;
}

Muted::~Muted() {
  --muted;
  if (who_ == Who::everybody) --everybody_muted;
}

void exit_on_fatal_error() {
  install([](const iox::Error error, const std::function<void()>&, const iox::ErrorLevel level) {
    if (level == iox::ErrorLevel::FATAL) die(error);
    errors.fetch_add(1, std::memory_order_relaxed);
  });
}

void count_errors() {
  install([](const iox::Error, const std::function<void()>&, const iox::ErrorLevel) { errors.fetch_add(1, std::memory_order_relaxed); });
}

uint64_t counted_errors() { return errors.load(std::memory_order_relaxed); }

}  // namespace vdisp
