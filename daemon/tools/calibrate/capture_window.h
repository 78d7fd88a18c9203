// capture_window.h: what `capture` shows in a window: both views, the board that is found, where boards were, which tilts are there.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <string>

#include "daemon/tools/calibrate/view_collector.h"
#include "probe/picture.h"
#include "probe/view/window.h"

namespace vdisp::calibrate {

/// One moment of a capture.
struct CaptureScreen {
  const cv::Mat* views = nullptr;  ///< left, right, gray8; null: no pair yet
  const Board* board = nullptr;    ///< what is looked for
  const BoardView* seen[2] = {};   ///< as found in the views, or null
  const ViewCollector* collector = nullptr;
  size_t wanted = 0;
  std::string message;  ///< what it waits for
};

/// The whole window: views above, the nine parts of the left image and the four tilts below.
Picture draw_capture(const CaptureScreen& screen, int width, int height);

class CaptureWindow {
 public:
  /// Throws ToolError (69) where there is no display.
  CaptureWindow();
  void show(const CaptureScreen& screen);
  struct Asked {
    bool take = false, undo = false, quit = false;
  };
  /// Keys since the last call; waits for the first at most so long.
  Asked keys(int limit_ms);

 private:
  Window window_;
};

}  // namespace vdisp::calibrate
