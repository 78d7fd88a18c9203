// contests.h: what is timed: each name with our way, the peer's way, and what is asked of the ratio.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tests/bench/frames.h"

namespace vdisp::bench {

/// One way to do the work. prepare() is not timed; result() is what the last run() made, or null.
struct Work {
  std::function<void()> prepare, run;
  std::function<const Image*()> result;
};

/// 0: nothing is asked.
struct Asked {
  double least_ratio = 0, aim_ratio = 0;  ///< peer / ours
  double most_ms = 0, aim_ms = 0;         ///< of ours, where there is no peer
};

struct Contest {
  std::string name;
  Asked asked;                            ///< with one thread
  Asked asked_of_two;                     ///< with two threads
  std::function<Work(int threads)> ours;  ///< throws std::exception saying why it cannot be timed
  std::function<Work(int threads)> peer;  ///< empty: nobody else does this
  double pixel_disparities = 0;           ///< what the matcher has to search, for names whose cost grows with it
};

struct Images {
  Frames vga, quarter, large;                            ///< 640x480, 320x240, 1280x960
  std::vector<std::pair<std::string, Frames>> recorded;  ///< more pairs, by name
};

/// What is asked of our side of every contest: SECTION.KEY=VALUE that go before the contest's own, and the instruction set.
struct OurSide {
  std::vector<std::string> sets;
  std::string cpu = "auto";
};

std::vector<Contest> contests(const Images& images, const OurSide& side);

}  // namespace vdisp::bench
