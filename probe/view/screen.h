// screen.h: what the window shows, drawn into a picture: a bar, the stage, its legend, the value under the cursor, the tree.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "ipc/include/vdisp/client.h"
#include "probe/paint.h"
#include "probe/view/panel.h"

namespace vdisp {

struct ScreenState {
  std::vector<CatalogueEntry> entries;
  int shown = -1;                 ///< index into entries
  const Image* image = nullptr;   ///< the last valid one of the stage shown; null: none yet
  const Image* height = nullptr;  ///< `height` of about the same frame, valid; null: not there
  Trust trust = Trust::dead;
  Reason reason = Reason::none;
  double age_s = 0;
  double rate = 0;        ///< images per second
  std::string trouble;    ///< why there is no daemon
  std::string recording;  ///< what is being recorded: "REC 123"; empty: nothing is
  bool drives = false;    ///< keys and mouse drive the rover
  std::string drive;      ///< the order that is held
  std::string message;    ///< shown for a while: "saved ..."
  PaintStyle style;
  bool tree = true, help = false, frozen = false;
  int mouse_x = -1, mouse_y = -1;
  Panel panel;  ///< where it is open it stands in the tree's place
};

/// Where the panel of the sliders is in a window of this size; of width 0 where there is no room.
Box panel_room(int width, int height);
/// The whole window, width x height.
Picture draw_screen(const ScreenState& state, int width, int height);

}  // namespace vdisp
