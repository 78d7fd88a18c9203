// census_view.cpp: one kernel by bands of rows.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/census_view.h"

#include "daemon/stages/projection.h"

namespace vdisp {

ImageSpec CensusView::accept(const ImageSpec& in) {
  require(in, Pixel::gray8, "the view");
  return in;
}

bool CensusView::filter(const Image& in, Image& out) noexcept {
  constexpr int least_band = 32;  // rows
  machine_.bands.run(in.spec.height, least_band,
                     [&](int first, int last, int) { machine_.kernels.census3x3(plane<uint8_t>(in), first, last, plane<uint8_t>(out)); });
  return true;
}

}  // namespace vdisp
