// view.cpp: vdisp-probe view: pages through the stages; what is shown is subscribed, and the height beside it: only they are computed.
// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <optional>

#include "ipc/png.h"
#include "probe/attach.h"
#include "probe/frame_set.h"
#include "probe/hand_drive.h"
#include "probe/kept.h"
#include "probe/recorded.h"
#include "probe/view/screen.h"
#include "probe/view/tuner.h"
#include "probe/view/window.h"

namespace vdisp {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds draw_period{33}, idle_period{250}, catalogue_period{1000}, message_time{4000};

class Viewer {
 public:
  Viewer(Client& client, Control& control, const Options& options)
      : client_(client), window_("vdisp-probe " + options.name, 960, 620, options.drive || options.window), tuner_(options.control) {
    state_.drives = options.drive || options.window;
    if (state_.drives) hand_.emplace(control, options.speed, options.turn);
    if (options.window) recorder_.emplace(client, control, options);
    const std::string first = options.topics.empty() ? "" : options.topics.front();
    take_catalogue(first.empty() ? client.topics(Client::Time(1500)) : topics_of(client));
    if (!first.empty()) require(state_.entries, first);
    for (size_t i = 0; i < state_.entries.size(); ++i) {
      if (name_of(state_.entries[i]) == first) show(static_cast<int>(i));
    }
  }

  const DriveRecorder* recorder() const { return recorder_ ? &*recorder_ : nullptr; }

  /// Until the operator ends it, or the recording is over.
  void run() {
    view();
    if (recorder_) recorder_->finish();
  }

 private:
  void view() {
    while (!quit_) {
      const auto since = std::chrono::duration_cast<milliseconds>(Clock::now() - drawn_);
      const int longest = hand_ || recorder_ ? 4 : 1000;  // ms: frames and orders do not wait for the picture
      const int limit = static_cast<int>(std::clamp<int64_t>((draw_period - since).count(), 1, longest));
      for (auto input = window_.wait(limit); input; input = window_.wait(0)) handle(*input);
      if (stopped() || quit_ || !go_on()) return;
      hear();
      look();
      const auto now = Clock::now();
      if (now - drawn_ < (changed_ ? draw_period : idle_period)) continue;
      draw(now);
    }
  }

  /// Drives and records. False: what was to be recorded is.
  bool go_on() {
    const std::string before = state_.drive + state_.recording;
    if (hand_) {
      hand_->tick(window_.hands(), Clock::now());
      state_.drive = hand_->words();
    }
    const bool more = !recorder_ || recorder_->poll(Client::Time(0));
    if (recorder_) {
      state_.recording = "REC " + std::to_string(recorder_->pairs()) + " " + std::string(name(recorder_->label()));
      if (!recorder_->warning().empty() && !warned_) {
        warned_ = true;
        state_.message = recorder_->warning();
        message_until_ = Clock::now() + message_time;
      }
    }
    changed_ = changed_ || before != state_.drive + state_.recording;
    return more;
  }

  /// What the daemon says to what was turned.
  void hear() {
    const auto line = tuner_.hear();
    if (!line) return;
    changed_ = true;
    if (!line->empty()) tell(*line);
  }

  void draw(Clock::time_point now) {
    drag();
    if (now > message_until_) state_.message.clear();
    state_.image = kept_.get();
    state_.height = kept_height_.get();
    state_.mouse_x = window_.mouse_x();
    state_.mouse_y = window_.mouse_y();
    if (state_.image) tuner_.follow(state_.image->config_generation);
    state_.panel = tuner_.panel();
    window_.show(draw_screen(state_, window_.width(), window_.height()));
    drawn_ = now;
    changed_ = false;
  }

  void handle(Input input) {
    changed_ = true;
    switch (input) {
      case Input::next_stage: return step_stage(1);
      case Input::previous_stage: return step_stage(-1);
      case Input::next_image: return step_image(1);
      case Input::previous_image: return step_image(-1);
      case Input::palette: state_.style.palette = static_cast<Palette>((static_cast<int>(state_.style.palette) + 1) % palettes); return;
      case Input::save: return save();
      case Input::space: state_.frozen = !state_.frozen && kept_.get(); return;
      case Input::tree: state_.tree = !state_.tree; return;
      case Input::help: state_.help = !state_.help; return;
      case Input::quit: quit_ = true; return;
      case Input::moved: drag_waits_ = tuner_.dragging(); return;
      case Input::pressed: return press();
      case Input::released: drag(); return tuner_.let_go();
      case Input::panel: return tuner_.open(!tuner_.panel().open);
      default: return tune(input);
    }
  }

  void tune(Input input) {
    if (!tuner_.panel().open) return tell("p shows the parameters first");
    switch (input) {
      case Input::next_slider: return tuner_.choose(1);
      case Input::previous_slider: return tuner_.choose(-1);
      case Input::more: return tuner_.step(1);
      case Input::less: return tuner_.step(-1);
      case Input::undo: return tuner_.undo();
      case Input::write: return tuner_.save();
      case Input::all_sliders: return tuner_.show_all(!tuner_.panel().everything);
      default: return;
    }
  }

  void tell(const std::string& text) {
    state_.message = text;
    message_until_ = Clock::now() + message_time;
  }

  /// In the panel a slider, elsewhere the next stage.
  void press() {
    const Box room = panel_room(window_.width(), window_.height());
    if (!tuner_.panel().open || window_.mouse_x() < room.x) return step_stage(1);
    if (const auto found = hit(room, tuner_.panel(), window_.mouse_x(), window_.mouse_y())) tuner_.press(found->slider, found->place);
  }

  /// However often the mouse moves, the daemon is asked once for each picture that is drawn.
  void drag() {
    if (!drag_waits_) return;
    drag_waits_ = false;
    tuner_.drag(place_along(panel_room(window_.width(), window_.height()), window_.mouse_x()));
  }

  /// First entry of each stage, in the order of the pipeline.
  std::vector<int> firsts() const {
    std::vector<int> result;
    for (size_t i = 0; i < state_.entries.size(); ++i) {
      const bool known =
          std::any_of(result.begin(), result.end(), [&](int first) { return state_.entries[first].stage == state_.entries[i].stage; });
      if (!known) result.push_back(static_cast<int>(i));
    }
    return result;
  }

  void step_stage(int by) {
    if (state_.shown < 0) return;
    const std::vector<int> stages = firsts();
    const auto here = std::find_if(stages.begin(), stages.end(),
                                   [&](int first) { return state_.entries[first].stage == state_.entries[state_.shown].stage; });
    const auto count = static_cast<int>(stages.size()), at = static_cast<int>(here - stages.begin());
    show(stages[(at + by + count) % count]);
  }

  void step_image(int by) {
    if (state_.shown < 0) return;
    std::vector<int> images;
    int at = 0;
    for (size_t i = 0; i < state_.entries.size(); ++i) {
      if (state_.entries[i].stage != state_.entries[state_.shown].stage) continue;
      if (static_cast<int>(i) == state_.shown) at = static_cast<int>(images.size());
      images.push_back(static_cast<int>(i));
    }
    const auto count = static_cast<int>(images.size());
    if (count > 1) show(images[(at + by + count) % count]);
  }

  void show(int index) {
    const CatalogueEntry& entry = state_.entries[index];
    state_.shown = index;
    tuner_.show(name_of(entry));
    window_.set_title(std::string(name_of(entry)) + " " + std::to_string(entry.spec.width) + "x" + std::to_string(entry.spec.height));
    if (name_of(entry) == topic_name_) return;
    if (topic_ >= 0) client_.unsubscribe(topic_);
    topic_name_ = name_of(entry);
    topic_ = client_.subscribe(topic_name_);
    follow_height(entry);
    kept_.drop();
    seen_ready_ns_ = 0;
    state_.image = nullptr;
    state_.rate = 0;
    state_.frozen = false;
    state_.trust = Trust::stale;
    changed_ = true;
  }

  /// Of pictures of its size `height` tells what lies under the cursor.
  void follow_height(const CatalogueEntry& shown) {
    kept_height_.drop();
    const bool needed = topic_name_ != "height" && std::any_of(state_.entries.begin(), state_.entries.end(), [&](const CatalogueEntry& e) {
                          return name_of(e) == "height" && e.spec.width == shown.spec.width && e.spec.height == shown.spec.height;
                        });
    if (!needed && height_ >= 0) client_.unsubscribe(height_);
    if (!needed) height_ = -1;
    if (needed && height_ < 0) height_ = client_.subscribe("height");
  }

  /// The daemon may have come back with another tree: the stage shown is found again by its name.
  void take_catalogue(std::vector<CatalogueEntry> entries) {
    catalogue_asked_ = Clock::now();
    if (entries.empty()) return;
    state_.entries = std::move(entries);
    state_.style.picture_rows = picture_rows_of(state_.entries);
    const auto same =
        std::find_if(state_.entries.begin(), state_.entries.end(), [&](const CatalogueEntry& e) { return name_of(e) == topic_name_; });
    show(same == state_.entries.end() ? 0 : static_cast<int>(same - state_.entries.begin()));
    changed_ = true;
  }

  void look() {
    if (Clock::now() - catalogue_asked_ > catalogue_period) take_catalogue(client_.topics(Client::Time(0)));
    if (topic_ < 0) {
      if (client_.connection() != Connection::connected) state_.trouble = client_.message();
      return;
    }
    if (state_.frozen) return;
    const Reading reading = client_.latest(topic_);
    if (reading.trust != state_.trust || reading.reason != state_.reason) changed_ = true;
    state_.trust = reading.trust;
    state_.reason = reading.reason;
    state_.age_s = reading.age_s;
    if (reading.trust == Trust::dead) {
      const bool there = client_.connection() == Connection::connected;
      state_.trouble = there ? "the daemon gives no sign of life" : client_.message();
    }
    if (!reading.image || reading.image->ready_ns == seen_ready_ns_) return;
    seen_ready_ns_ = reading.image->ready_ns;
    changed_ = true;
    const bool record = reading.image->spec.pixel == Pixel::record;
    if (record || reading.image->valid()) kept_.keep(*reading.image);
    if (height_ >= 0) keep_height();
    measure_rate(*reading.image);
  }

  /// A frame more or less is no matter to the eye; a height of long ago is.
  void keep_height() {
    constexpr uint64_t near = 5;  // frames
    const Reading reading = client_.latest(height_);
    const Image *height = reading.image, *shown = kept_.get();
    const bool same = height && shown && height->valid() && height->epoch == shown->epoch && height->sequence + near >= shown->sequence &&
                      height->sequence <= shown->sequence + near;
    if (same) {
      kept_height_.keep(*height);
    } else {
      kept_height_.drop();
    }
  }

  /// Frames per second from the numbers of the frames: the display itself may skip some.
  void measure_rate(const Image& image) {
    const auto now = Clock::now();
    const double seconds = std::chrono::duration<double>(now - rate_since_).count();
    if (image.epoch == rate_epoch_ && image.sequence >= rate_sequence_ && seconds < 1) return;
    const bool known = image.epoch == rate_epoch_ && image.sequence >= rate_sequence_ && seconds < 3;
    state_.rate = known ? static_cast<double>(image.sequence - rate_sequence_) / seconds : 0;
    rate_since_ = now;
    rate_epoch_ = image.epoch;
    rate_sequence_ = image.sequence;
  }

  void save() {
    const Image* image = kept_.get();
    message_until_ = Clock::now() + message_time;
    if (!image) {
      state_.message = "nothing to save yet";
      return;
    }
    std::string file = topic_name_ + "-" + std::to_string(image->sequence) + ".png";
    std::replace(file.begin(), file.end(), '/', '-');
    try {
      const std::filesystem::path path = std::filesystem::current_path() / file;
      const Picture picture = portrait(topic_name_, *image, state_.style);
      write_file(path, encode_png(PngKind::rgb8, picture.width(), picture.height(), [&](int y) { return picture.row(y); }));
      state_.message = "saved " + path.string();
    } catch (const std::exception& error) {  // also a working folder that is gone
      state_.message = error.what();
    }
  }

  Client& client_;
  Window window_;
  Tuner tuner_;
  ScreenState state_;
  KeptImage kept_, kept_height_;
  Client::Topic topic_ = -1, height_ = -1;
  std::string topic_name_;
  int64_t seen_ready_ns_ = 0;
  bool quit_ = false, changed_ = true, warned_ = false;
  bool drag_waits_ = false;  // the mouse has moved with a slider
  std::optional<HandDrive> hand_;
  std::optional<DriveRecorder> recorder_;
  Clock::time_point drawn_{}, catalogue_asked_{}, message_until_{}, rate_since_{};
  uint64_t rate_sequence_ = 0, rate_epoch_ = 0;
};

}  // namespace

int view(const Options& options) {
  Client client(options.name);
  stop_on_signals();
  attach(client, options);
  Control control(options.control, std::chrono::milliseconds(100));
  try {
    Viewer viewer(client, control, options);
    viewer.run();
    if (viewer.recorder()) tell_recorded(*viewer.recorder(), options);
  } catch (const NoWindow& error) {
    throw ProbeError(69, std::string(error.what()) + "; without one use vdisp-probe map");
  }
  return 0;
}

}  // namespace vdisp
