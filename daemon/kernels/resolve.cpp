// resolve.cpp: the plain form: which hypothesis a pixel follows, its sub-pixel part, its reason.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/kernels/resolve.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace vdisp::kernels::plain {
namespace {

struct Match {
  int whole;  // 1/16 px, without the sub-pixel part
  int cost, before, after, refused;
};

Match match_of(const Hypothesis& hypothesis, int x, int moved) {
  const Candidates& c = hypothesis.candidates;
  return {16 * (hypothesis.min_disparity + c.index[x]) + moved, c.cost[x], c.before[x], c.after[x], c.refused[x]};
}

int more(int cost, int factor) { return cost + (cost * factor >> 16); }

/// `ground`: disparity of the floor; `home`: what it costs.
Match choose(const Resolve& r, const Match& match, const Match& floor, int ground, int home) {
  const bool floor_wins = floor.cost <= match.cost;
  const bool same = std::abs(floor.whole - match.whole) <= same_disparity;
  const bool only_one = (floor.refused == 0) != (match.refused == 0);
  const bool take_floor = same && only_one ? floor.refused == 0 : floor_wins;
  Match taken = take_floor ? floor : match;
  const int rival = take_floor ? match.cost : floor.cost;
  const bool rivalled = !same && rival <= more(taken.cost, r.unique);
  const bool on_floor = std::abs(taken.whole - ground) <= off_floor;
  const bool explained = !on_floor && home <= more(taken.cost, r.floor_margin);
  if (r.unique > 0 && (rivalled || explained)) taken.refused |= candidate_not_unique;
  return taken;
}

int sub_pixel(const Match& m) {
  const int steep = std::max(m.before, m.after) - m.cost;
  if (steep <= 0) return 0;
  return static_cast<int>(std::floor(static_cast<float>(8 * (m.before - m.after)) / static_cast<float>(steep) + 0.5f));
}

}  // namespace

void resolve_row(const Resolve& r, const Hypothesis& match, const Hypothesis* floor, const RowDisparity& floor_disparity,
                 const uint16_t* texture, int16_t* out) {
  std::fill_n(out, r.width, r.outside);
  const int least = 16 * r.min_disparity, most = 16 * (r.min_disparity + r.disparities - 1);
  for (int x = match.first; x < match.last; ++x) {
    Match taken = match_of(match, x, 0);
    if (floor && x >= floor->first && x < floor->last) {
      const int ground = floor_at(floor_disparity, x);
      taken = choose(r, taken, match_of(*floor, x, ground), ground, floor->candidates.home[x]);
    }
    const int disparity = taken.whole + sub_pixel(taken);
    if (texture[x] < r.texture_least) {
      out[x] = r.low_texture;
    } else if (disparity < least || disparity > most) {
      out[x] = r.outside;
    } else if (taken.refused) {
      out[x] = taken.refused & candidate_not_unique ? r.not_unique : r.left_right;
    } else {
      out[x] = static_cast<int16_t>(disparity);
    }
  }
}

}  // namespace vdisp::kernels::plain
