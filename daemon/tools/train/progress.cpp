// progress.cpp: draws the bar, at most ten times a second.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/tools/train/progress.h"

#include <unistd.h>

#include <cstdio>

namespace vdisp::train {
namespace {

using namespace std::chrono_literals;
constexpr std::chrono::milliseconds redraw = 100ms, line = 10s;
constexpr size_t bar = 30;  // characters

}  // namespace

Progress::Progress(std::string what, size_t total)
    : what_(std::move(what)),
      total_(total ? total : 1),
      terminal_(isatty(STDERR_FILENO) == 1),
      start_(Clock::now()),
      next_(start_ + (terminal_ ? 0s : line)) {}

Progress::~Progress() {
  if (!shown_) return;
  show(done_, Clock::now());
  if (terminal_) std::fputc('\n', stderr);
}

void Progress::add(size_t done) {
  const size_t all = done_ += done;
  std::unique_lock lock(showing_, std::try_to_lock);
  const auto now = Clock::now();
  if (!lock || now < next_) return;
  next_ = now + (terminal_ ? Clock::duration(redraw) : Clock::duration(line));
  shown_ = true;
  show(all, now);
}

void Progress::show(size_t done, Clock::time_point now) {
  const double part = static_cast<double>(done) / static_cast<double>(total_),
               seconds = std::chrono::duration<double>(now - start_).count();
  const double left = part > 0 ? seconds / part - seconds : 0;
  if (!terminal_) {
    std::fprintf(stderr, "vdisp-train: %s: %zu of %zu, %.0f s\n", what_.c_str(), done, total_, seconds);
    return;
  }
  const auto full = static_cast<size_t>(part * bar);
  std::fprintf(stderr, "\r%-24s [%s%s] %3.0f %%  %5.0f s, %.0f s left \033[K", what_.c_str(), std::string(full, '#').c_str(),
               std::string(bar - full, '.').c_str(), 100 * part, seconds, left);
  std::fflush(stderr);
}

}  // namespace vdisp::train
