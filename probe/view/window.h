// window.h: a window with a picture in it, and what the operator does there. Behind it SDL, without a graphics card.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

#include "probe/picture.h"
#include "probe/view/hands.h"

namespace vdisp {

enum class Input {
  next_stage,
  previous_stage,
  next_image,
  previous_image,
  palette,
  save,
  space,
  tree,
  help,
  quit,
  moved,     ///< the mouse, or it left
  pressed,   ///< its left button, at mouse_x(), mouse_y()
  released,  ///< the same
  panel,
  next_slider,
  previous_slider,
  more,
  less,
  undo,
  write,
  all_sliders
};

/// There is no display, or it gives no window: why, in one line.
class NoWindow : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class Window {
 public:
  /// `drives`: arrow keys, mouse buttons and a gamepad do not page through the stages, but show in hands().
  /// Throws NoWindow.
  Window(const std::string& title, int width, int height, bool drives = false);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  /// What was done next; waits for it at most this long.
  std::optional<Input> wait(int limit_ms);
  /// What is held now; kept up by wait().
  const Hands& hands() const;
  void show(const Picture& picture);
  void set_title(const std::string& title);
  int width() const;
  int height() const;
  /// Of the cursor; -1, -1 outside the window.
  int mouse_x() const;
  int mouse_y() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace vdisp
