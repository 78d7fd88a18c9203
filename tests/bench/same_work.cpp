// same_work.cpp: both sides have run once, on the same images.
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/same_work.h"

#include <algorithm>
#include <cstdlib>
#include <iomanip>

namespace vdisp::bench {
namespace {

void compare_views(std::ostream& out, const Image& ours, const Image& peer) {
  int most = 0;
  for (int v = 0; v < ours.spec.height; ++v)
    for (int u = 0; u < ours.spec.width; ++u) most = std::max(most, std::abs(ours.row<uint8_t>(v)[u] - peer.row<uint8_t>(v)[u]));
  out << "grey levels differ by " << most << " at most\n";
}

void compare_disparities(std::ostream& out, const Image& ours, const Image& peer) {
  int mine = 0, other = 0, both = 0, near = 0;
  for (int v = 0; v < ours.spec.height; ++v) {
    for (int u = 0; u < ours.spec.width; ++u) {
      const int a = ours.row<int16_t>(v)[u], b = peer.row<int16_t>(v)[u];
      mine += a > 0;
      other += b > 0;
      if (a <= 0 || b <= 0) continue;
      ++both;
      near += std::abs(a - b) <= 16;
    }
  }
  const double all = 0.01 * ours.spec.width * ours.spec.height;
  out << std::fixed << std::setprecision(1) << mine / all << " % of the pixels have a disparity, the peer's " << other / all << " %; of "
      << both / all << " % that both have " << 100.0 * near / std::max(both, 1) << " % agree within 1 px\n";
}

}  // namespace

void write_same_work(std::ostream& out, const Result& result, const Work& ours, const Work& peer) {
  if (result.threads != 1 || !result.skipped.empty() || !ours.result || !peer.result) return;
  const Image &mine = *ours.result(), &other = *peer.result();
  if (mine.spec != other.spec) return;
  if (mine.spec.pixel == Pixel::gray8) {
    compare_views(out << result.contest->name << ": ", mine, other);
  } else if (mine.spec.pixel == Pixel::disparity16) {
    compare_disparities(out << result.contest->name << ": ", mine, other);
  }
}

}  // namespace vdisp::bench
