// terminal.cpp: termios and the few escape codes that every terminal since the VT100 knows.
// SPDX-License-Identifier: Apache-2.0
#include "probe/terminal.h"

#include <langinfo.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <clocale>
#include <cstring>

#include "probe/attach.h"

namespace vdisp {
namespace {

winsize size() {
  winsize window{};
  if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &window) != 0 || window.ws_col == 0 || window.ws_row == 0) window = {24, 80, 0, 0};
  return window;
}

/// 0, or why it cannot be written. A signal that asks us to end also ends a wait for a slow terminal or pipe.
int put(std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = write(STDOUT_FILENO, text.data(), text.size());
    const int error = written < 0 ? errno : written == 0 ? ENOSPC : 0;
    if (error == EAGAIN) {  // somebody who shares the terminal made it non-blocking
      pollfd output{STDOUT_FILENO, POLLOUT, 0};
      poll(&output, 1, 100);
    }
    const bool passing = (error == EINTR || error == EAGAIN) && !stopped();
    if (error && !passing) return error;
    if (!error) text.remove_prefix(static_cast<size_t>(written));
  }
  return 0;
}

}  // namespace

bool utf8_terminal() {
  setlocale(LC_CTYPE, "");
  return std::strcmp(nl_langinfo(CODESET), "UTF-8") == 0;
}

size_t letters(std::string_view text) {
  return static_cast<size_t>(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xc0) != 0x80; }));
}

void print(std::string_view text) {
  const int error = put(text);
  if (error && !stopped()) throw ProbeError(74, std::string("the output cannot be written: ") + std::strerror(error));
}

LiveScreen::LiveScreen() : live_(isatty(STDOUT_FILENO) == 1) {
  if (!live_) return;
  keys_ = isatty(STDIN_FILENO) == 1 && tcgetattr(STDIN_FILENO, &before_) == 0;
  if (keys_) {
    termios now = before_;
    now.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
    now.c_cc[VSUSP] = _POSIX_VDISABLE;  // a stopped process would leave its screen behind
    now.c_cc[VMIN] = 0;
    now.c_cc[VTIME] = 0;
    tcsetattr(STDIN_FILENO, TCSANOW, &now);
  }
  put("\x1b[?1049h\x1b[?25l\x1b[2J");
}

LiveScreen::~LiveScreen() {
  if (!live_) return;
  put("\x1b[0m\x1b[?25h\x1b[?1049l");
  if (keys_) tcsetattr(STDIN_FILENO, TCSANOW, &before_);
}

int LiveScreen::columns() const { return size().ws_col; }
int LiveScreen::rows() const { return size().ws_row; }

void LiveScreen::show(const std::string& text) {
  if (!live_) return print(text);
  std::string out = "\x1b[H";
  int room = rows();
  for (size_t at = 0; at < text.size() && room > 0; --room) {
    const size_t end = std::min(text.find('\n', at), text.size());
    out += text.substr(at, end - at) + "\x1b[0m\x1b[K" + (room > 1 ? "\r\n" : "");
    at = end + 1;
  }
  print(out + "\x1b[0m\x1b[J");
}

char LiveScreen::key(int limit_ms) {
  pollfd input{STDIN_FILENO, POLLIN, 0};
  if (poll(&input, keys_ ? 1 : 0, limit_ms) <= 0 || !(input.revents & POLLIN)) return 0;
  char key = 0;
  return read(STDIN_FILENO, &key, 1) == 1 ? key : '\0';
}

}  // namespace vdisp
