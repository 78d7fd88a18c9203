// main.cpp: vdispd: options, the tree, shared memory, and the loop that drives it.
// SPDX-License-Identifier: Apache-2.0
#include <sysexits.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <iostream>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>

#include "daemon/core/clock.h"
#include "daemon/core/pace.h"
#include "daemon/dump.h"
#include "daemon/failure.h"
#include "daemon/health_report.h"
#include "daemon/log/edges.h"
#include "daemon/log/log.h"
#include "daemon/options.h"
#include "daemon/publish.h"
#include "daemon/recorder.h"
#include "daemon/service/realtime.h"
#include "daemon/service/service.h"
#include "daemon/tree.h"

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
    recorder_.add_report(driver_);
    if (!options.dot.empty()) write_graph(driver_, options.dot);
    if (!options.dump.empty()) dump_.emplace(options.dump, options.images);
    shared_ = publish(driver_, config_, dump_ ? options.dump : options.record);
    const bool serves = shared_ != nullptr;  // else a recording is evaluated, by one configuration
    control_.emplace(config_, ConfigOrigin{options.file, options.sets, serves}, inputs_, serves,
                     [](std::string_view line, bool fault) { fault ? log::warn("{}", line) : log::info("{}", line); });
    report_.emplace(config_, *source_, inputs_, *control_);
    driver_.set_reporter([this](Health& health, const Catalogue& catalogue) { (*report_)(health, catalogue); });
    recorder_.start(options.record, driver_, config_, source_->calibration(), epoch_);
    if (dump_) driver_.need_all();
    service_.emplace(config_, [this] { return !shared_ || shared_->attachable(); });
    driver_.set_viewer([this](const Topic& topic, const Image& image) {
      edges_.see(topic, image);
      service_->see(topic, image);
      if (dump_) dump_->see(topic, image);
      recorder_.see(topic, image);
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
      service_->stepped(outcome, driver_, source_->fault());
      if (driver_.steps() == 1)
        log::info("ready: {} topics, {}", driver_.topics().size(), shared_ ? "published as " + config_.main.name : "not published");
      if (dump_) dump_->finish_frame(driver_, source_->files());
      recorder_.finish_step();
      if (options_.frames && driver_.steps() >= options_.frames) break;
      wait_for_next(
          due, stop_asked, [this] { return period_ns(); }, [this] { driver_.beat(), serve(); });
    }
    recorder_.finish();
  }

  /// Readers survive only this way of ending (ipc/shm.h).
  void leave(int exit_code) {
    alarm(15);  // a camera that does not answer takes seconds
    service_->stopping();
    source_->close();  // the process may end without destructors, and a GigE camera would not know for 3 s
    alarm(2);          // a stderr that nobody reads must not keep the daemon: SIGALRM ends it
    if (exit_code == EX_OK) driver_.write_profile(std::cerr);
    log::stop();
    report_.reset();
    control_.reset();
    if (shared_) SharedMemory::leave(exit_code);
  }

 private:
  /// What came by the control socket, or in vdisp.cfg, between two frames.
  void serve() {
    service_->expect(period_ns());
    for (std::string line; source_->news(line);) log::info("{}", line);
    if (flight_asked) recorder_.ask_flight();
    flight_asked = 0;
    const int64_t period = std::max<int64_t>(source_->pair_period_ns(), config_.main.period * 1'000'000LL);
    driver_.set_deadline(static_cast<int64_t>(config_.main.deadline * 1e6), period);
    const bool changed = control_->serve(driver_.sequence());
    if (inputs_.recording_begins()) driver_.begin_anew();
    if (!changed) return;
    driver_.set_config_generation(control_->generation());
    log::set_level(config_.main.debug);
  }

  int64_t period_ns() const { return std::max<int64_t>(source_->period_ns(), config_.main.period * 1'000'000LL); }

  const Options& options_;
  Config& config_;  // changed between two frames only, by set and undo
  log::Edges edges_;
  Inputs inputs_;
  Machine machine_;
  const uint64_t epoch_;
  Driver driver_;
  StereoSource* source_ = nullptr;  // owned by the driver
  std::unique_ptr<SharedMemory> shared_;
  std::optional<CommandSocket> control_;
  std::optional<HealthReport> report_;
  std::optional<Dump> dump_;
  std::optional<Service> service_;
  Recorder recorder_;
};

int main(int argc, char** argv) {
  Parsed parsed = parse_options(argc, argv);
  if (parsed.exit_code) return *parsed.exit_code;
  for (int signal : {SIGINT, SIGTERM}) std::signal(signal, [](int) { stop_asked = 1; });
  std::signal(SIGUSR1, [](int) { flight_asked = 1; });
  ConfigWatch::hold_hangup();
  std::signal(SIGPIPE, SIG_IGN);
  log::start(parsed.options.config.main.debug);
  std::optional<Run> run;
  int exit_code = EX_OK;
  try {
    take_processors(parsed.options.config.main);
    run.emplace(parsed.options);
    run->loop();
  } catch (...) {
    log::stop();
    exit_code = explain(std::current_exception());
  }
  if (run) run->leave(exit_code);
  return exit_code;
}

}  // namespace
}  // namespace vdisp

int main(int argc, char** argv) { return vdisp::main(argc, argv); }
