// height.cpp: the plain form.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/kernels/height.h"

#include <algorithm>

namespace vdisp::kernels::plain {

void measure_heights(const int16_t* disparity, int n, const Search& search, const HeightRow& row, const HeightTable& table,
                     const HeightOut& out) {
  for (int u = 0; u < n; ++u) {
    const int d = disparity[u];
    out.height[u] = out.none;
    out.surface[u] = static_cast<uint8_t>(Surface::none);
    out.obstacles[u] = out.overhangs[u] = out.refused;
    if (!search.counts(d)) continue;
    const float floor = row.step * static_cast<float>(u) + row.first;
    const HeightOf of = table[d - search.first];
    const float height = row.camera - floor * of.inverse - of.profile;
    const int mm = static_cast<int>(std::clamp(height, -32000.0f, 32000.0f));
    out.height[u] = static_cast<int16_t>(mm);
    Surface surface = Surface::floor;
    if (mm >= row.step_mm) surface = Surface::obstacle;
    if (mm >= row.clearance_mm) surface = Surface::overhang;
    if (mm <= -row.hole_mm) surface = Surface::below;
    out.surface[u] = static_cast<uint8_t>(surface);
    if (surface == Surface::obstacle) out.obstacles[u] = disparity[u];
    if (surface == Surface::overhang) out.overhangs[u] = disparity[u];
  }
}

}  // namespace vdisp::kernels::plain
