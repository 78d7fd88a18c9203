// capture.cpp: the word `capture`: looks at the running daemon's cameras, and takes the views of a board that are worth it by itself.
// SPDX-License-Identifier: Apache-2.0
#include <sysexits.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <optional>

#include "daemon/tools/calibrate/capture_window.h"
#include "daemon/tools/calibrate/daemon_views.h"
#include "daemon/tools/calibrate/view_collector.h"
#include "daemon/tools/calibrate/words.h"
#include "ipc/include/vdisp/client.h"
#include "ipc/png.h"

namespace vdisp::calibrate {
namespace {

using Time = Client::Time;
constexpr Time to_frame(500), to_first_frame(10000);

volatile std::sig_atomic_t stop_asked = 0;

/// Behind the largest number among its files; 0 where there is none.
int next_number(const std::filesystem::path& folder) {
  int next = 0;
  std::error_code error;
  for (std::filesystem::directory_iterator i(folder, error), end; !error && i != end; i.increment(error)) {
    const std::string stem = i->path().stem().string();
    int number = 0;
    const auto [rest, fault] = std::from_chars(stem.data(), stem.data() + stem.size(), number);
    if (fault == std::errc() && rest == stem.data() + stem.size()) next = std::max(next, number + 1);
  }
  return next;
}

/// DIR/left and DIR/right; views are numbered on from those that are there, behind any gap among them.
class Album {
 public:
  explicit Album(const std::filesystem::path& folder) : folder_(folder) {
    for (const char* side : {"left", "right"})
      if (std::error_code error; !std::filesystem::create_directories(folder / side, error) && error)
        throw write_error("cannot create", folder / side, error.value());
    for (const char* side : {"left", "right"}) number_ = std::max(number_, next_number(folder / side));
  }
  std::string add(const cv::Mat (&views)[2]) {
    const char* sides[] = {"left", "right"};
    for (int i : {0, 1})
      write_file(file(sides[i]), encode_png(PngKind::gray8, views[i].cols, views[i].rows, [&](int y) { return views[i].ptr(y); }));
    const std::string name = file("left").filename().string();
    ++number_;
    ++added_;
    return name;
  }
  /// The last one that was added here is gone again. Empty: there is none.
  std::string take_back() {
    if (added_ == 0) return {};
    --number_, --added_;
    std::error_code error;
    for (const char* side : {"left", "right"}) std::filesystem::remove(file(side), error);
    return file("left").filename().string();
  }

 private:
  std::filesystem::path file(const char* side) const {
    char name[32];
    std::snprintf(name, sizeof name, "%06d.png", number_);
    return folder_ / side / name;
  }
  std::filesystem::path folder_;
  int number_ = 0, added_ = 0;
};

/// On a terminal one line that is kept up to date; lines of their own are for views that are taken.
class Teller {
 public:
  void now(const std::string& text) {
    if (live_ && text != last_) std::cout << "\r\033[K" << text << std::flush;
    last_ = text;
  }
  void line(const std::string& text) { std::cout << (live_ ? "\r\033[K" : "") << text << '\n' << std::flush; }

 private:
  bool live_ = isatty(STDOUT_FILENO) == 1;
  std::string last_;
};

std::string words(Look look) {
  switch (look) {
    case Look::taken: return "taken";
    case Look::no_board: return "no board in both views";
    case Look::moving: return "hold the board still";
    case Look::known: break;
  }
  return "seen like that already";
}

std::string state(const ViewCollector& collector, size_t wanted) {
  std::string text = std::to_string(collector.taken()) + " of " + std::to_string(wanted) + "  [";
  for (size_t i = 0; i < 9; ++i) text += (i == 3 || i == 6 ? "|" : "") + std::string(collector.covered(i) ? "#" : ".");
  return text + "]";
}

/// What solve has to be told of the same board.
std::string solve_command(const Options& options) {
  const std::filesystem::path folder(options.output);
  const BoardOptions& board = options.board;
  char square[32], marker[32];
  std::snprintf(square, sizeof square, "%g", board.square_m);
  std::snprintf(marker, sizeof marker, "%g", board.marker_m);
  std::string command = "vdisp-calibrate solve " + (folder / "left").string() + " " + (folder / "right").string() + " --board " +
                        board.size + " --square " + square;
  if (board.kind == "charuco") {
    command += " --kind charuco --dictionary " + board.dictionary;
    if (board.marker_m > 0) command += std::string(" --marker ") + marker;
  }
  return command + " -o rover.yml";
}

/// One capture: pairs come from the daemon, views go to the album, and what happens to the terminal and, if asked for, a window.
class Capture {
 public:
  explicit Capture(const Options& options)
      : options_(options),
        wanted_(static_cast<size_t>(options.views)),
        board_(options.board),
        album_(options.output),
        client_(options.name) {
    for (int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, [](int) { stop_asked = 1; });
    if (options.window) window_.emplace();
    attach(client_);
    topics_[0] = client_.subscribe("camera/left"), topics_[1] = client_.subscribe("camera/right");
    if (!client_.wait_set(topics_, readings_, to_first_frame))
      throw ToolError(EX_UNAVAILABLE,
                      "no pair of camera/left and camera/right within 10 s; " +
                          (client_.message().empty() ? std::string("vdisp-probe stats tells what the daemon does") : client_.message()));
    const ImageSpec& spec = readings_[0].image->spec;
    collector_.emplace(board_, cv::Size(spec.width, spec.height), wanted_);
    size_ = cv::Size(spec.width, spec.height);
  }

  void run() {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(options_.seconds);
    while (!stop_asked && !quit_ && !collector_->complete() && (options_.seconds == 0 || std::chrono::steady_clock::now() < end)) {
      obey();
      if (client_.wait_set(topics_, readings_, to_frame) && readings_[0].fresh() && readings_[1].fresh())
        look();
      else
        tell_now(client_.message().empty() ? "no fresh pair" : client_.message());
    }
    if (collector_->complete())
      teller_.line("complete: " + solve_command(options_));
    else
      teller_.line(state(*collector_, wanted_) + "  ended" +
                   (collector_->missing().empty() ? "" : "; still missing: " + collector_->missing()));
  }

 private:
  void look() {
    for (size_t i : {0u, 1u}) views_[i] = picture_of(*readings_[i].image);
    for (Client::Topic topic : topics_) client_.release(topic);
    if (views_[0].size() != size_ || views_[1].size() != size_)
      throw ToolError(EX_UNAVAILABLE, "the daemon's images changed their size; needed is a new start");
    boards_[0] = board_.find(views_[0]);
    boards_[1] = boards_[0].empty() ? BoardView() : board_.find(views_[1]);
    board_.agree(boards_[0], boards_[1]);
    keep_common(boards_[0], boards_[1]);
    const Look look = collector_->consider(boards_[0], boards_[1], take_);
    take_ = false;
    if (look == Look::taken) {
      const std::string name = album_.add(views_);
      teller_.line(state(*collector_, wanted_) + "  " + name + " taken");
      draw(name + " taken");
    } else {
      tell_now(words(look), collector_->missing().empty() ? "" : "; next: " + collector_->missing());
    }
  }
  /// `next` in the terminal alone: the window shows it.
  void tell_now(const std::string& what, const std::string& next = {}) {
    teller_.now(state(*collector_, wanted_) + "  " + what + next);
    draw(what);
  }
  void draw(const std::string& message) {
    if (!window_) return;
    CaptureScreen screen;
    if (!views_[0].empty()) screen.views = views_;
    screen.board = &board_;
    screen.seen[0] = &boards_[0], screen.seen[1] = &boards_[1];
    screen.collector = &*collector_;
    screen.wanted = wanted_;
    screen.message = message;
    window_->show(screen);
  }
  /// Keys of the window.
  void obey() {
    if (!window_) return;
    const CaptureWindow::Asked asked = window_->keys(0);
    take_ = take_ || asked.take;
    quit_ = asked.quit;
    if (!asked.undo) return;
    const std::string name = album_.take_back();
    if (name.empty()) return;
    collector_->undo();
    teller_.line(state(*collector_, wanted_) + "  " + name + " taken back");
  }

  const Options& options_;
  size_t wanted_;
  Board board_;
  Album album_;
  Client client_;
  Client::Topic topics_[2];
  Reading readings_[2];
  cv::Size size_;
  std::optional<ViewCollector> collector_;
  std::optional<CaptureWindow> window_;
  Teller teller_;
  cv::Mat views_[2];
  BoardView boards_[2];
  bool take_ = false, quit_ = false;
};

}  // namespace

int capture(const Options& options) {
  Capture(options).run();
  return EX_OK;
}

}  // namespace vdisp::calibrate
