// map_text.h: the map in letters: half blocks in colour for a terminal, plain ASCII for pipes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "ipc/image.h"

namespace vdisp {

struct MapLook {
  int columns = 0, lines = 0;  ///< room in letters; 0: one letter is one cell wide and two high
  bool colour = false;         ///< 256 colours
  bool utf8 = false;           ///< half blocks
  bool old = false;            ///< greys: this is not the present
};

/// Lines, the farthest first; under them the camera, beside them the ranges in m. Obstacles are never lost in scaling down.
/// Without colour: '#' obstacle, '+' fewer points, '.' in view with nothing seen, ' ' out of view.
std::vector<std::string> map_text(const Image& map, const MapLook& look);

/// "nearest obstacle 1.85 m away, 12 deg to the left" of a valid map.
std::string nearest_words(const Image& map);

}  // namespace vdisp
