// ways.cpp: formats.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/ways.h"

namespace vdisp {

void Ways::prepare(std::span<const ImageSpec> in) {
  snow_ = !in.empty() && in.back() == record_spec<SnowScores>();
  maps_ = in.size() - (snow_ ? 1 : 0);
  if (in.empty() || maps_ > 2)
    throw FormatError("takes a grid with its reasons where it has some, and scores, was given " + std::to_string(in.size()) + " images");
  if (maps_ == 0) return;
  require(in[0], maps_ == 2 ? Pixel::int8 : Pixel::count16, "the grid");
  if (maps_ == 2) {
    require(in[1], Pixel::gray8, "the reason");
    require_same_size(in[0], in[1]);
  }
  map_.prepare(in[0]);
}

}  // namespace vdisp
