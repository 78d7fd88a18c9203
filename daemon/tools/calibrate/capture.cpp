// capture.cpp: the word `capture`: looks at the running daemon's cameras, and takes the views of a board that are worth it by itself.
// SPDX-License-Identifier: Apache-2.0
#include <sysexits.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <iostream>

#include "daemon/tools/calibrate/view_collector.h"
#include "daemon/tools/calibrate/words.h"
#include "ipc/include/vdisp/client.h"
#include "ipc/png.h"

namespace vdisp::calibrate {
namespace {

using Time = Client::Time;
constexpr Time to_connect(2500), to_frame(500), to_first_frame(10000);

volatile std::sig_atomic_t stop_asked = 0;

void attach(Client& client) {
  if (client.wait_for_daemon(to_connect)) return;
  const Connection connection = client.connection();
  const int code = connection == Connection::no_permission ? EX_NOPERM
                   : connection == Connection::no_memory   ? EX_OSERR
                   : connection == Connection::wrong_name  ? EX_USAGE
                                                           : EX_UNAVAILABLE;
  throw ToolError(code, client.message());
}

cv::Mat picture_of(const Image& image) {
  return cv::Mat(image.spec.height, image.spec.width, CV_8U, const_cast<uint8_t*>(image.row<uint8_t>(0)), image.spec.stride()).clone();
}

/// DIR/left and DIR/right; views are numbered on from those that are there.
class Album {
 public:
  explicit Album(const std::filesystem::path& folder) : folder_(folder) {
    for (const char* side : {"left", "right"})
      if (std::error_code error; !std::filesystem::create_directories(folder / side, error) && error)
        throw write_error("cannot create", folder / side, error.value());
    while (std::filesystem::exists(file("left")) || std::filesystem::exists(file("right"))) ++number_;
  }
  std::string add(const cv::Mat (&views)[2]) {
    const char* sides[] = {"left", "right"};
    for (int i : {0, 1})
      write_file(file(sides[i]), encode_png(PngKind::gray8, views[i].cols, views[i].rows, [&](int y) { return views[i].ptr(y); }));
    const std::string name = file("left").filename().string();
    ++number_;
    return name;
  }

 private:
  std::filesystem::path file(const char* side) const {
    char name[32];
    std::snprintf(name, sizeof name, "%06d.png", number_);
    return folder_ / side / name;
  }
  std::filesystem::path folder_;
  int number_ = 0;
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

const char* words(Look look) {
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
  for (size_t i = 0; i < 9; ++i) text += (i == 3 || i == 6 ? "|" : "") + std::string(collector.cells()[i] > 5 ? "#" : ".");
  return text + "]";
}

}  // namespace

int capture(const Options& options) {
  const Board board(options.board);
  Album album(options.output);
  Client client(options.name);
  for (int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, [](int) { stop_asked = 1; });
  attach(client);
  const Client::Topic topics[] = {client.subscribe("camera/left"), client.subscribe("camera/right")};
  Reading readings[2];
  if (!client.wait_set(topics, readings, to_first_frame))
    throw ToolError(EX_UNAVAILABLE,
                    "no pair of camera/left and camera/right within 10 s; " +
                        (client.message().empty() ? std::string("vdisp-probe stats tells what the daemon does") : client.message()));
  const cv::Size size(readings[0].image->spec.width, readings[0].image->spec.height);
  ViewCollector collector(board, size, static_cast<size_t>(options.views));
  Teller teller;
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(options.seconds);
  while (!stop_asked && !collector.complete() && (options.seconds == 0 || std::chrono::steady_clock::now() < end)) {
    if (!client.wait_set(topics, readings, to_frame) || !readings[0].fresh() || !readings[1].fresh()) {
      teller.now(client.message().empty() ? "no fresh pair" : client.message());
      continue;
    }
    const cv::Mat views[2] = {picture_of(*readings[0].image), picture_of(*readings[1].image)};
    for (Client::Topic topic : topics) client.release(topic);
    if (views[0].size() != size || views[1].size() != size)
      throw ToolError(EX_UNAVAILABLE, "the daemon's images changed their size; needed is a new start");
    BoardView left = board.find(views[0]), right;
    if (!left.empty()) right = board.find(views[1]);
    board.agree(left, right);
    keep_common(left, right);
    const Look look = collector.consider(left, right);
    if (look == Look::taken)
      teller.line(state(collector, static_cast<size_t>(options.views)) + "  " + album.add(views) + " taken");
    else
      teller.now(state(collector, static_cast<size_t>(options.views)) + "  " + words(look) +
                 (collector.missing().empty() ? "" : "; next: " + collector.missing()));
  }
  if (collector.complete())
    teller.line("complete: vdisp-calibrate solve " + (std::filesystem::path(options.output) / "left").string() + " " +
                (std::filesystem::path(options.output) / "right").string() + " --board " + options.board.size + " --square ...");
  else
    teller.line(state(collector, static_cast<size_t>(options.views)) + "  ended" +
                (collector.missing().empty() ? "" : "; still missing: " + collector.missing()));
  return EX_OK;
}

}  // namespace vdisp::calibrate
