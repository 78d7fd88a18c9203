// drive_recorder.cpp: which frames are taken, and what lies beside them.
// SPDX-License-Identifier: Apache-2.0
#include "probe/drive_recorder.h"

#include <algorithm>
#include <charconv>

#include "probe/config_text.h"
#include "probe/samples.h"

namespace vdisp {
namespace {

constexpr std::chrono::seconds patience{10};
constexpr std::chrono::milliseconds again{700};
constexpr int most_asks = 4;
constexpr const char* needed[] = {"camera/left", "camera/right", "in/odometry", "in/imu", "in/drive", "in/event"};
constexpr const char* useful[] = {"calibration", "truth/steering", "drive"};

/// It came in with this step.
bool tells_beginning(const Image& image) {
  const Events* events = record_of<Events>(image);
  for (uint32_t i = 0; events && i < std::min({events->tally.in_step, events->count, Events::capacity}); ++i)
    if (events->entries[i].text() == recording_label) return true;
  return false;
}

}  // namespace

DriveRecorder::DriveRecorder(Client& client, Control& control, const Options& options)
    : client_(client), control_(control), options_(options) {
  std::error_code error;
  for (const char* file : {"recording.json", "index.csv"})
    if (std::filesystem::exists(options.output / file, error))
      throw WriteError(73, options.output.string() + ": holds a recording already; name an empty or a new folder");
  const std::vector<CatalogueEntry> entries = topics_of(client);
  for (const char* topic : needed) require(entries, topic), names_.emplace_back(topic);
  for (const char* topic : useful)
    if (std::any_of(entries.begin(), entries.end(), [&](const CatalogueEntry& entry) { return name_of(entry) == topic; }))
      names_.emplace_back(topic);
  take_parameters();
  for (const std::string& name : names_) topics_.push_back(client.subscribe(name));
  readings_.resize(names_.size());
  if (options.rate > 0 || options.running) return;
  awaited_ = true;
}

DriveRecorder::~DriveRecorder() {
  for (Client::Topic topic : topics_) client_.unsubscribe(topic);
}

/// Before the first frame: it takes the daemon some steps to tell them all.
void DriveRecorder::take_parameters() {
  Control control(options_.control, limit_of_all);  // control_ may not wait so long
  if (control.get_all(parameters_) == Control::Result::done) return;
  parameters_.clear();
  warn("the recording has no vdisp.cfg, and a replay takes the defaults: " + control.message());
}

void DriveRecorder::warn(const std::string& what) { warning_ += (warning_.empty() ? "" : "; ") + what; }

/// When a first whole frame has come: then the stages run that are recorded.
void DriveRecorder::ask_for_beginning() {
  asked_ = Clock::now();
  if (control_.event(recording_label) == Control::Result::done) return;
  awaited_ = false;
  warn("the stages remember what came before the recording, and a replay does not: " + control_.message());
}

bool DriveRecorder::poll(Client::Time limit) {
  const auto now = Clock::now();
  if (steps_ > 0 && options_.seconds > 0 && now - begun_ >= std::chrono::duration<double>(options_.seconds)) return false;
  const bool found = client_.wait_set(topics_, readings_, limit) &&
                     std::all_of(readings_.begin(), readings_.end(), [](const Reading& reading) { return reading.image != nullptr; });
  if (!found || (epoch_ == readings_[0].image->epoch && last_sequence_ == readings_[0].image->sequence)) {
    if (now - heard_ < patience) return true;
    const bool daemon = client_.connection() == Connection::connected;
    throw ProbeError(69, daemon ? "the daemon made no whole frame of what is recorded within 10 s; see vdisp-probe stats"
                                : client_.message() + "; what was recorded until then is kept");
  }
  heard_ = now;
  const Image& camera = *readings_[0].image;
  if (epoch_ != 0 && camera.epoch != epoch_)
    throw ProbeError(69, "the daemon was started anew: the recording ends, what was recorded until then is kept");
  if (begins(camera) && is_due(camera.timestamp_ns)) take(camera);
  epoch_ = camera.epoch;
  last_sequence_ = camera.sequence;
  // Not released: what has come of the next frame already would go with it.
  return true;
}

bool DriveRecorder::begins(const Image& camera) {
  if (!awaited_) return true;
  if (asked_ == Clock::time_point{}) ask_for_beginning();
  const auto event = std::find(names_.begin(), names_.end(), "in/event") - names_.begin();
  if (tells_beginning(*readings_[static_cast<size_t>(event)].image)) awaited_ = false;
  if (awaited_ && Clock::now() - asked_ > again && ++asks_ < most_asks) ask_for_beginning();  // that frame was missed
  if (awaited_ && Clock::now() - asked_ > again) {
    awaited_ = false;
    warn("the daemon does not take events (frame " + std::to_string(camera.sequence) +
         "): the stages remember what came before the recording, and a replay does not");
  }
  return !awaited_;
}

bool DriveRecorder::is_due(int64_t timestamp_ns) {
  if (options_.rate <= 0) return true;
  const auto period = static_cast<int64_t>(1e9 / options_.rate);
  // A frame that comes a little early is nearer than the next one.
  if (due_ns_ != INT64_MIN && timestamp_ns < due_ns_ - period / 16) return false;
  due_ns_ = due_ns_ == INT64_MIN || timestamp_ns > due_ns_ + period ? timestamp_ns + period : due_ns_ + period;
  return true;
}

std::string DriveRecorder::value_of(const char* key) const {
  const auto found = std::find_if(parameters_.begin(), parameters_.end(), [&](const ParameterInfo& info) { return info.key == key; });
  return found == parameters_.end() ? std::string() : found->value;
}

void DriveRecorder::open(const Image& camera) {
  RecordingInfo info;
  info.program = "vdisp-probe " VDISP_VERSION;
  info.source = value_of("image source.source");
  if (info.source == "sim") {
    info.world = value_of("sim.scene");
    const std::string seed = value_of("sim.seed");
    std::from_chars(seed.data(), seed.data() + seed.size(), info.seed);
  }
  info.epoch = camera.epoch;
  info.width = camera.spec.width;
  info.height = camera.spec.height;
  info.synthetic = (camera.flags & flag_synthetic) != 0;
  std::vector<std::pair<std::string, std::string>> texts;
  for (const Reading& reading : readings_) {
    const CalibrationText* text = record_of<CalibrationText>(*reading.image);
    if (text && reading.image->valid())
      texts.emplace_back("calibration.yml", std::string(text->text, std::min<size_t>(text->size, sizeof text->text)));
  }
  ConfigText config;
  for (const ParameterInfo& parameter : parameters_) config.add(parameter.key, written(parameter));
  if (!parameters_.empty()) texts.emplace_back("vdisp.cfg", "# As vdispd had it when this was recorded.\n\n" + config.text());
  thread_ = std::make_unique<RecordThread>(options_.output, info, texts, camera.spec);
  begun_ = Clock::now();
}

void DriveRecorder::take(const Image& camera) {
  if (!thread_) open(camera);
  if (steps_ > 0 && options_.rate <= 0) lost_ += camera.sequence - last_sequence_ - 1;
  for (size_t i = 0; i < names_.size(); ++i) thread_->see(names_[i], *readings_[i].image);
  const bool pair = camera.valid();
  label_ = thread_->finish_step();
  ++steps_;
  pairs_ += pair;
  if (pair) ++labels_[static_cast<size_t>(label_)];
}

void DriveRecorder::finish() {
  if (thread_) thread_->finish();
}

}  // namespace vdisp
