// frames.h: the images that are timed: raw pairs of the simulator, the same in every run, and what OpenCV makes of them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "config/config.h"
#include "daemon/geometry/calibration.h"
#include "tests/support/picture.h"

namespace vdisp::bench {

/// The images that the source of a tree gives out in one step, in order.
using Set = std::vector<std::shared_ptr<Picture>>;

struct Frames {
  std::optional<Calibration> calibration;
  std::vector<Set> raw, rectified;  ///< left, right
  ImageSpec spec() const { return raw.at(0).at(0)->spec(); }
};

/// Defaults, then each SECTION.KEY=VALUE. Throws std::invalid_argument with the first complaint.
Config config_of(const std::vector<std::string>& sets);

/// `count` pairs, each of another scene of posts, boxes and rocks on flat ground, by cameras as the paper's rover carries them
/// (0.8 m high, 15 deg down), with their noise, distortion and misalignment.
Frames simulated(int width, int height, int count);
/// The first pairs of a recording that is rectified already.
Frames recorded(const std::string& left, const std::string& right, const std::string& calibration, int count);

}  // namespace vdisp::bench
