// flight_recorder.cpp: a ring whose oldest steps are written over, but for those that are being written out.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/record/flight_recorder.h"

#include <algorithm>
#include <cstring>

#include "daemon/core/background.h"
#include "daemon/core/clock.h"
#include "daemon/log/log.h"

namespace vdisp {
namespace {

constexpr int64_t patience_ns = 5'000'000'000;
constexpr int lasting = 3;  // steps: a single bad pair is no lost camera
constexpr size_t fewest = 4;

uint64_t bytes_of(const ImageSpec& camera) { return 2ull * camera.stride() * camera.height; }

}  // namespace

FlightRecorder::FlightRecorder(const Config& config, const ImageSpec& camera, RecordingInfo info, Texts texts)
    : config_(config), camera_(camera), info_(std::move(info)), texts_(std::move(texts)), taker_(camera) {
  const uint64_t bytes = static_cast<uint64_t>(config.recorder.memory) << 20, each = bytes_of(camera) + sizeof(TakenStep);
  const size_t count = std::max<size_t>(bytes / each, fewest);
  ring_.reserve(count);
  for (size_t i = 0; i < count; ++i) ring_.emplace_back(camera);
  taken_ns_.assign(count, 0);
  result_.reserve(sizeof status_.text);
  status_.flight = 1;
  status_.room = count;
  begin_step();
  thread_ = std::thread([this] { run(); });
}

FlightRecorder::~FlightRecorder() {
  ending_ns_ = monotonic_ns();
  given_.release();
  thread_.join();
  if (asked_ != FlightCause::none) log::warn("flight recorder: the daemon ends: no folder is written for {}", describe(asked_));
}

bool FlightRecorder::lost(Watched& subject, bool there) noexcept {
  subject.known = subject.known || there;
  subject.missing = there ? 0 : std::min(subject.missing + 1, lasting + 1);
  return subject.known && subject.missing == lasting;
}

void FlightRecorder::ask(FlightCause cause) noexcept {
  if (asked_ == FlightCause::none) asked_ = cause;
}

void FlightRecorder::happened(FlightCause cause, int64_t now_ns) noexcept {
  if (now_ns - begun_ns_ >= static_cast<int64_t>(config_.recorder.seconds * 1e9)) ask(cause);
}

void FlightRecorder::see(std::string_view topic, const Image& image) noexcept {
  taker_.see(topic, image);
  if (topic == "camera/left") {
    camera_there_ = image.valid();
    if (lost(view_, image.valid())) happened(FlightCause::camera_lost, image.ready_ns);
  } else if (topic == "floor_model" && camera_there_) {
    if (lost(floor_, image.valid())) happened(FlightCause::floor_lost, image.ready_ns);
  } else if (const Events* events = record_of<Events>(image)) {
    for (uint32_t i = 0; i < std::min({events->tally.in_step, events->count, Events::capacity}); ++i) {
      if (events->entries[i].text().starts_with(dump_flight_label)) ask(FlightCause::asked);
      if (events->entries[i].text().starts_with(bump_label)) happened(FlightCause::bump, image.ready_ns);
    }
  }
}

void FlightRecorder::begin_step() noexcept {
  const uint64_t needed_from = needed_from_.load(std::memory_order_acquire);
  taking_ = next_ < ring_.size() || next_ - ring_.size() < needed_from;
  if (taking_) taker_.begin(ring_[next_ % ring_.size()]);
}

void FlightRecorder::finish_step(int64_t now_ns) noexcept {
  if (!taking_) {
    ++status_.lost;
  } else if (taker_.finish()) {
    taken_ns_[next_ % ring_.size()] = now_ns;
    ++next_;
  }
  if (status_.writing && !busy_.load(std::memory_order_acquire)) take_result();
  if (asked_ != FlightCause::none && !status_.writing) start_writing(now_ns);
  begin_step();
  const uint64_t oldest = next_ > ring_.size() ? next_ - ring_.size() : 0;
  status_.held = next_ - oldest;
  status_.held_s = next_ ? static_cast<double>(taken_ns_[(next_ - 1) % ring_.size()] - taken_ns_[oldest % ring_.size()]) * 1e-9 : 0;
}

void FlightRecorder::take_result() noexcept {
  status_.writing = 0;
  ++(failed_ ? status_.failed : status_.written);
  std::memset(status_.text, 0, sizeof status_.text);
  result_.copy(status_.text, sizeof status_.text - 1);
}

/// Steps of the last seconds; what comes from here on is not written.
void FlightRecorder::start_writing(int64_t now_ns) noexcept {
  first_ = next_ > ring_.size() ? next_ - ring_.size() : 0;
  const int64_t since_ns = now_ns - static_cast<int64_t>(config_.recorder.seconds * 1e9);
  while (first_ < next_ && taken_ns_[first_ % ring_.size()] < since_ns) ++first_;
  end_ = next_;
  cause_ = status_.cause = asked_;
  asked_ = FlightCause::none;
  room_.keep = config_.recorder.keep;
  room_.least_free = static_cast<uint64_t>(config_.recorder.free) << 20;
  begun_ns_ = now_ns;
  status_.writing = 1;
  ++status_.asked;
  needed_from_.store(first_, std::memory_order_release);
  busy_.store(true, std::memory_order_release);
  given_.release();
}

void FlightRecorder::tell(RecorderStatus& status) const noexcept {
  const uint32_t recording = status.recording;
  const uint64_t recorded = status.recorded;
  status = status_;
  status.recording = recording;
  status.recorded = recorded;
}

void FlightRecorder::run() noexcept {
  begin_in_background("flight");
  room_.folder = config_.recorder.folder;  // no live key
  while (true) {
    given_.acquire();
    if (!busy_.load(std::memory_order_acquire)) {
      if (ending_ns_) return;
      continue;
    }
    failed_ = true;
    try {
      write();
      failed_ = false;
    } catch (const std::exception& error) {
      result_ = error.what();
      log::warn("flight recorder: {}", result_);
    }
    needed_from_.store(nothing, std::memory_order_release);
    busy_.store(false, std::memory_order_release);
    if (ending_ns_) return;
  }
}

void FlightRecorder::write() {
  const std::filesystem::path folder = find_flight_folder(room_, cause_, (end_ - first_) * bytes_of(camera_));
  try {
    write_to(folder);
  } catch (...) {
    drop_broken(room_, folder);
    throw;
  }
  drop_oldest(room_, folder);
}

void FlightRecorder::write_to(const std::filesystem::path& folder) {
  RecordingWriter writer(folder, info_, texts_());
  for (uint64_t number = first_; number < end_; ++number) {
    if (const int64_t since = ending_ns_; since && monotonic_ns() - since > patience_ns)
      throw WriteError(75, folder.string() + ": given up after " + std::to_string(number - first_) + " of " +
                               std::to_string(end_ - first_) + " steps: the daemon ends, and the disk is slow");
    const TakenStep& taken = ring_[number % ring_.size()];
    writer.add(taken.step, taken.step.has_pair() ? &taken.views : nullptr);
    needed_from_.store(number + 1, std::memory_order_release);
  }
  result_ = folder.string();
  log::info("flight recorder: {} steps, {} pairs, in {}, for {}", end_ - first_, writer.pairs(), result_, describe(cause_));
}

}  // namespace vdisp
