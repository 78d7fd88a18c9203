// hands.h: what hands hold in a window.
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace vdisp {

/// What is held in the window at this moment. Without focus nothing is.
struct Hands {
  bool focus = false;
  bool up = false, down = false, left = false, right = false;   ///< arrow keys
  bool mouse = false, mouse_left = false, mouse_right = false;  ///< driving by mouse; its buttons
  bool stick = false;                                           ///< a gamepad's stick is off its middle
  double stick_ahead = 0, stick_left = 0;                       ///< -1 to 1
};

}  // namespace vdisp
