// daemon_views.h: what the running daemon sees: its views, how they were rectified, and what it is set to.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "daemon/geometry/frames.h"
#include "ipc/image.h"

namespace vdisp {
class Client;
}

namespace vdisp::calibrate {

/// Connects within 2.5 s. Throws ToolError: 69 no daemon, 77 no permission, 71 no memory, 64 no such name.
void attach(Client& client);
/// A copy of a gray8 image.
cv::Mat picture_of(const Image& image);

/// Its parameters as SECTION.KEY=VALUE, those that pairs are judged by; empty where it does not tell.
std::vector<std::string> settings_of_daemon();

struct DaemonViews {
  std::vector<std::array<cv::Mat, 2>> camera, rectified;  ///< pairs: left, right
  StereoView view;                                        ///< of the rectified ones; not calibrated(): the daemon has no calibration
  uint64_t calibration_hash = 0;
  int blind = 0;  ///< pairs that it could not vouch for
};

/// At most `most` pairs, spread over so many seconds. Throws ToolError: 69 where none is good.
DaemonViews look_at_daemon(const std::string& name, int most, double seconds);

}  // namespace vdisp::calibrate
