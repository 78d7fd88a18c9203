// panel.h: the sliders as they are drawn, and which of them lies under the mouse.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "probe/picture.h"
#include "probe/view/slider.h"

namespace vdisp {

struct Panel {
  bool open = false, everything = false;
  bool waits = false;  ///< the daemon is asked for all of them
  std::vector<Slider> sliders;
  size_t chosen = 0;
  std::string trouble;  ///< why there are none, or why one was refused
};

void draw_panel(Picture& page, Box room, const Panel& panel);

struct PanelHit {
  size_t slider;
  double place;  ///< 0 to 1 along its bar, also from beyond its ends
};
/// The slider in whose row (x, y) lies; nothing outside.
std::optional<PanelHit> hit(Box room, const Panel& panel, int x, int y);
/// Where x is along the bars, 0 to 1: for a mouse that has left the row it drags.
double place_along(Box room, int x);

}  // namespace vdisp
