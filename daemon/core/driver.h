// driver.h: runs the tree: stages in the order they were added, those that somebody needs, timed, published.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <iosfwd>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "daemon/core/ledger.h"
#include "daemon/core/processor.h"
#include "daemon/core/topic.h"
#include "ipc/outlet.h"
#include "ipc/records.h"

namespace vdisp {

/// The paper's IPLDriver. Build: add() each stage, then connect(). Run: step() until it says end.
class Driver {
 public:
  /// `epoch` marks this start of the daemon.
  explicit Driver(uint64_t epoch);
  ~Driver();
  Driver(const Driver&) = delete;
  Driver& operator=(const Driver&) = delete;

  /// Adds a stage that makes the topics `names` of `inputs`, which must have been added before: the order is the schedule.
  /// Throws FormatError naming the stage, its inputs, what was found and what was needed.
  std::vector<Handle> add_set(std::vector<std::string> names, std::unique_ptr<ImageProcessor> stage, std::vector<Handle> inputs = {},
                              Need need = Need::on_demand);
  /// The same for a stage that makes one topic, as most do.
  Handle add(const std::string& name, std::unique_ptr<ImageProcessor> stage, std::vector<Handle> inputs = {}, Need need = Need::on_demand);

  /// What the topic `name`, which may be added later, showed in the last frame: an input for add(), but not the first one, except for a
  /// source that heeds it (ImageSource::heeds). The only way back. Its name and `spec` are checked in connect(). It may be blind
  /// (no_last_image where nothing was made), which does not make its reader blind. Steps without a frame leave it as it is: its sequence
  /// tells its age.
  Handle last(const std::string& name, const ImageSpec& spec);
  /// Gives each topic, and the driver's own `catalogue`, `health` and `heartbeat`, a way out. After this nothing allocates.
  /// Throws FormatError where what last() was asked for is not made, or is something else.
  void connect(const OutletFactory& outlet);
  /// The topic that the rover drives by: its blindness, latency and deadline are counted (Health). The last one named holds.
  void set_result(Handle result) { result_ = result.topic; }
  /// Ledger::set_deadline(), from the next result on.
  void set_deadline(int64_t of_exposure_ns, int64_t period_ns) noexcept { ledger_.set_deadline(of_exposure_ns, period_ns); }
  /// Called once a second: adds to `health` what the driver does not know, just before it is published.
  using Reporter = std::function<void(Health& health, const Catalogue& catalogue)>;
  void set_reporter(Reporter reporter) { reporter_ = std::move(reporter); }
  /// Of all images from the next step on.
  void set_config_generation(uint64_t generation) noexcept { config_generation_ = generation; }
  /// The topic's stage runs in every step, watched or not. False: there is no such topic.
  bool need(const std::string& topic);
  /// Every stage runs in every step, watched or not.
  void need_all();

  /// Between two steps: every stage forgets what earlier frames left (a recording begins). The source goes on, and so do the numbers.
  void begin_anew() noexcept;
  /// The number of the next frame, where a recording tells it; each one after that has the next number.
  void set_sequence(uint64_t sequence) noexcept { sequence_ = sequence; }
  uint64_t sequence() const { return sequence_; }
  /// One frame through the tree. invalid: the source had no frame, the step was blind.
  Outcome step() noexcept;
  /// Publishes heartbeat, catalogue and health when they are due. Call between steps, and at least five times a second while waiting.
  void beat() noexcept;

  const std::vector<Topic>& topics() const { return topics_; }
  /// Topics of the tree and the driver's own, with their sizes: what shared memory has to hold.
  std::vector<Topic> published_topics() const;
  using Viewer = std::function<void(const Topic&, const Image&)>;
  /// Called in the loop for every image just before it is published: must not allocate or wait (--dump does).
  void set_viewer(Viewer viewer) { viewer_ = std::move(viewer); }

  StageTiming timing(Handle topic) const;
  uint64_t steps() const { return steps_; }
  uint64_t blind_steps() const { return blind_steps_; }
  uint64_t drops() const;

  /// The tree as a Graphviz graph.
  void write_dot(std::ostream& out) const;
  /// IPL's profile: what each stage cost, dearest first.
  void write_profile(std::ostream& out) const;

 private:
  struct Stage;
  struct Slot;
  struct Delayed;
  void choose_stages() noexcept;
  Outcome run(Stage& stage) noexcept;
  void publish(Slot& slot) noexcept;
  void publish_after(int stage) noexcept;
  void fill_catalogue(Catalogue& catalogue) const noexcept;
  void fill_health(Health& health) const noexcept;
  int64_t period_ns() const noexcept;
  int find_delayed(const std::string& reader, Delayed& delayed);
  const std::string& name_of(Handle input) const;
  const ImageSpec& spec_of(Handle input) const;
  std::string label(const Stage& stage) const;

  uint64_t epoch_, config_generation_ = 0;
  std::vector<Topic> topics_;
  std::vector<Slot> slots_;  // one for each topic
  std::vector<Stage> stages_;
  std::vector<Delayed> delayed_;
  std::unique_ptr<Outlet> catalogue_, health_, heartbeat_;
  Viewer viewer_;
  Reporter reporter_;
  Ledger ledger_;
  int result_ = -1;
  bool need_all_ = false;
  uint64_t steps_ = 0, blind_steps_ = 0, loans_ = 0, sequence_ = 0;  // of the next frame
  int64_t began_ns_ = 0;                                             // connect()
  int64_t step_total_ns_ = 0, last_beat_ns_ = 0, last_catalogue_ns_ = 0;
  std::array<int64_t, 32> step_starts_{};  // of the last steps, a ring: the period is theirs, so that a pause is soon forgotten
};

}  // namespace vdisp
