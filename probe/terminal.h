// terminal.h: the terminal as a place for a live picture: borrowed, and given back as it was.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <termios.h>

#include <string>
#include <string_view>

namespace vdisp {

/// True where the locale's letters are UTF-8.
bool utf8_terminal();
/// Letters of a UTF-8 text, which may be fewer than its bytes.
size_t letters(std::string_view text);

/// Writes all of it to stdout. Throws ProbeError (74) where that is not possible.
void print(std::string_view text);

/// While it lives: another screen, no cursor, keys at once. Where stdout is no terminal it does nothing.
class LiveScreen {
 public:
  LiveScreen();
  ~LiveScreen();
  LiveScreen(const LiveScreen&) = delete;
  LiveScreen& operator=(const LiveScreen&) = delete;

  bool live() const { return live_; }
  int columns() const;
  int rows() const;
  /// Replaces what is shown; lines end with \n. Throws ProbeError (74) where stdout takes nothing.
  void show(const std::string& text);
  /// The key pressed within the time limit, 0 for none; a signal ends the wait.
  char key(int limit_ms);

 private:
  bool live_ = false, keys_ = false;
  termios before_{};
};

}  // namespace vdisp
