// painted.h: empty pictures with a geometry, for tests of what the probe paints and says.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>

#include "ipc/outlet.h"

namespace vdisp {

template <class T>
void set(Image& image, int x, int y, T value) {
  image.row<T>(y)[x] = value;
}

inline BufferOutlet blank(Pixel pixel, uint16_t width, uint16_t height) {
  BufferOutlet outlet({pixel, 0, width, height});
  Image& image = outlet.loan();
  for (int y = 0; y < height; ++y) std::fill_n(image.row<std::byte>(y), image.spec.stride(), std::byte{});
  return outlet;
}

// The paper's rover: f 580 px, baseline 9 cm.
inline void give_camera(Image& image) { image.camera = {580, 320, 240, 0.09f, 0, 0, 48, {}}; }

inline void give_grid(Image& image) {
  image.grid = {};
  image.grid.cell = 0.1f;
  image.grid.origin_row = image.spec.height;
  image.grid.origin_column = image.spec.width / 2.0f;
  image.grid.view_left = -0.55f;
  image.grid.view_right = 0.55f;
  image.grid.min_count = 3;
}

}  // namespace vdisp
