// main.cpp: vdispd: options, the tree, shared memory, and the loop that drives it.
// SPDX-License-Identifier: Apache-2.0
#include <sysexits.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <iostream>
#include <opencv2/core.hpp>
#include <optional>

#include "daemon/control/command_socket.h"
#include "daemon/core/clock.h"
#include "daemon/core/pace.h"
#include "daemon/dump.h"
#include "daemon/failure.h"
#include "daemon/log/edges.h"
#include "daemon/log/log.h"
#include "daemon/options.h"
#include "daemon/recorder.h"
#include "daemon/tree.h"
#include "ipc/shm.h"

namespace vdisp {
namespace {

constexpr int longest_wait_ms = 100;  // for a pair: heartbeat and control socket wait as long

volatile std::sig_atomic_t stop_asked = 0;

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
    if (!options.dot.empty()) write_graph(driver_, options.dot);
    if (!options.dump.empty()) dump_.emplace(options.dump);
    publish();
    if (!options.record.empty()) record_ = start_record(options.record, driver_, config_, source_->calibration(), epoch_);
    if (dump_) driver_.need_all();
    driver_.set_viewer([this](const Topic& topic, const Image& image) {
      edges_.see(topic, image);
      if (dump_) dump_->see(topic, image);
      if (record_) record_->see(topic, image);
    });
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
      if (driver_.step() == Outcome::end) {
        if (!source_->fault().empty()) log::warn("{}", source_->fault());
        break;
      }
      driver_.beat();
      if (driver_.steps() == 1)
        log::info("ready: {} topics, {}", driver_.topics().size(), shared_ ? "published as " + config_.main.name : "not published");
      if (dump_) dump_->finish_frame(driver_, source_->files());
      if (record_) record_->finish_step();
      if (options_.frames && driver_.steps() >= options_.frames) break;
      wait_for_next(
          due, stop_asked, [this] { return period_ns(); }, [this] { driver_.beat(), serve(); });
    }
    if (record_) {
      record_->finish();
      log::info("{} pairs recorded in {}", record_->pairs(), options_.record);
    }
  }

  /// Readers survive only this way of ending (ipc/shm.h).
  void leave(int exit_code) {
    alarm(15);         // a camera that does not answer takes seconds
    source_->close();  // the process may end without destructors, and a GigE camera would not know for 3 s
    alarm(2);          // a stderr that nobody reads must not keep the daemon: SIGALRM ends it
    if (exit_code == EX_OK) driver_.write_profile(std::cerr);
    log::stop();
    control_.reset();
    if (shared_) SharedMemory::leave(exit_code);
  }

 private:
  void publish() {
    if (config_.main.middleware != "none") {
      TopicList topics;
      for (const Topic& topic : driver_.published_topics()) topics.emplace_back(topic.name, topic.spec);
      try {
        shared_.emplace(ShmOptions{config_.main.name, config_.ipc.group, static_cast<uint32_t>(config_.ipc.memory)}, topics);
      } catch (const ShmError& error) {
        // A recording can be evaluated beside the daemon that serves the rover.
        if ((!dump_ && options_.record.empty()) || error.exit_code != EX_UNAVAILABLE) throw;
        log::warn("{}; this run only writes {}", error.what(), dump_ ? options_.dump : options_.record);
      }
    }
    if (shared_) control_.emplace(config_, options_.file, inputs_, [](std::string_view line) { log::warn("{}", line); });
    driver_.connect([this](const std::string& topic, const ImageSpec& spec) -> std::unique_ptr<Outlet> {
      if (shared_) return shared_->outlet(topic, spec);
      return std::make_unique<BufferOutlet>(spec);
    });
  }

  /// What came by the control socket, between two frames.
  void serve() {
    for (std::string line; source_->news(line);) log::info("{}", line);
    if (!control_ || !control_->serve(driver_.steps())) return;
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
  std::optional<SharedMemory> shared_;
  std::optional<CommandSocket> control_;
  std::optional<Dump> dump_;
  std::unique_ptr<Record> record_;
};

int main(int argc, char** argv) {
  Parsed parsed = parse_options(argc, argv);
  if (parsed.exit_code) return *parsed.exit_code;
  for (int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, [](int) { stop_asked = 1; });
  std::signal(SIGPIPE, SIG_IGN);
  log::start(parsed.options.config.main.debug);
  std::optional<Run> run;
  int exit_code = EX_OK;
  try {
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
