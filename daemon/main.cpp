// main.cpp: vdispd: options, the tree, shared memory, and the loop that drives it.
// SPDX-License-Identifier: Apache-2.0
#include <sysexits.h>
#include <unistd.h>

#include <csignal>
#include <iostream>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>

#include "daemon/core/clock.h"
#include "daemon/core/pace.h"
#include "daemon/dump.h"
#include "daemon/failure.h"
#include "daemon/log/edges.h"
#include "daemon/log/log.h"
#include "daemon/options.h"
#include "daemon/publish.h"
#include "daemon/service/realtime.h"
#include "daemon/tree.h"
#include "daemon/upkeep.h"

namespace vdisp {
namespace {

constexpr int longest_wait_ms = 100;  // for a pair: heartbeat and control socket wait as long
volatile std::sig_atomic_t stop_asked = 0, flight_asked = 0;

/// One run: everything is built in the constructor, which may throw; after it nothing allocates, but for the dump.
class Run {
 public:
  explicit Run(Options& options)
      : options_(options),
        config_(options.config),
        edges_(config_, [this] { return source_ ? source_->fault() : std::string_view(); }),
        inputs_(config_),
        machine_(config_.main.threads, options.cpu),
        epoch_(wall_clock_ns()),
        driver_(epoch_) {
    cv::setNumThreads(config_.main.threads);
    log::debug("kernels for {}, threads: {}", machine_.level, machine_.bands.threads());
    auto source = open_source(config_);
    source_ = source.get();
    build_tree(driver_, std::move(source), machine_, config_, inputs_);
    upkeep_.emplace(driver_, config_, *source_, inputs_);
    if (!options.dot.empty()) write_graph(driver_, options.dot);
    if (!options.dump.empty()) dump_.emplace(options.dump, options.images);
    shared_ = publish(driver_, config_, dump_ ? options.dump : options.record);
    const bool serves = shared_ != nullptr;  // else a recording is evaluated, by one configuration
    upkeep_->begin({options.file, options.sets, serves}, options.record, epoch_, serves,
                   [this] { return !shared_ || shared_->attachable(); });
    if (dump_) driver_.need_all();
    driver_.set_viewer([this](const Topic& topic, const Image& image) {
      edges_.see(topic, image);
      upkeep_->see(topic, image);
      if (dump_) dump_->see(topic, image);
    });
    lock_memory(config_.main);
  }

  /// Frames until the source ends, --frames is reached or a signal asks.
  void loop() {
    int64_t due = monotonic_ns();
    while (!stop_asked) {
      serve();
      if (!source_->wait(longest_wait_ms)) {
        driver_.beat();
        continue;
      }
      if (const auto sequence = source_->next_sequence()) driver_.set_sequence(*sequence);
      const Outcome outcome = driver_.step();
      if (outcome == Outcome::end) {
        if (!source_->fault().empty()) log::warn("{}", source_->fault());
        break;
      }
      driver_.beat();
      upkeep_->stepped(outcome);
      if (driver_.steps() == 1)
        log::info("ready: {} topics, {}", driver_.topics().size(), shared_ ? "published as " + config_.main.name : "not published");
      if (dump_) dump_->finish_frame(driver_, source_->files());
      if (options_.frames && driver_.steps() >= options_.frames) break;
      wait_for_next(
          due, stop_asked, [this] { return upkeep_->period_ns(); }, [this] { driver_.beat(), serve(); });
    }
  }

  /// Ends all that writes, and all that logs. Throws WriteError where a recording is not whole.
  void finish() {
    alarm(15);  // a camera that does not answer takes seconds, and a disk may never answer
    upkeep_->stopping();
    source_->close();  // the process may end without destructors, and a GigE camera would not know for 3 s
    upkeep_->finish();
  }

  /// Readers survive only this way of ending (ipc/shm.h).
  void leave(int exit_code) {
    if (exit_code == EX_OK) driver_.write_profile(std::cerr);
    if (shared_) SharedMemory::leave(exit_code);
  }

 private:
  void serve() {
    const bool flight = flight_asked;
    if (flight) flight_asked = 0;
    upkeep_->serve(flight);
  }

  const Options& options_;
  Config& config_;  // changed between two frames only, by set and undo
  log::Edges edges_;
  Inputs inputs_;
  Machine machine_;
  const uint64_t epoch_;
  Driver driver_;
  StereoSource* source_ = nullptr;  // owned by the driver
  std::unique_ptr<SharedMemory> shared_;
  std::optional<Dump> dump_;
  std::optional<Upkeep> upkeep_;
};

int main(int argc, char** argv) {
  Parsed parsed = parse_options(argc, argv);
  if (parsed.exit_code) return *parsed.exit_code;
  for (int signal : {SIGINT, SIGTERM}) std::signal(signal, [](int) { stop_asked = 1; });
  std::signal(SIGUSR1, [](int) { flight_asked = 1; });
  ConfigWatch::hold_hangup();
  std::signal(SIGPIPE, SIG_IGN);
  std::optional<Run> run;
  std::exception_ptr failure;
  attempt(failure, [&] {
    log::start(parsed.options.config.main.debug);
    take_processors(parsed.options.config.main);
    run.emplace(parsed.options);
    run->loop();
  });
  if (run) attempt(failure, [&] { run->finish(); });
  alarm(4);  // a stderr that nobody reads must not keep the daemon: SIGALRM ends it, before systemd would
  log::stop();
  const int exit_code = failure ? explain(failure) : EX_OK;
  if (run) run->leave(exit_code);
  return exit_code;
}

}  // namespace
}  // namespace vdisp

int main(int argc, char** argv) { return vdisp::main(argc, argv); }
