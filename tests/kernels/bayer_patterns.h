// bayer_patterns.h: the four Bayer patterns and their names.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "daemon/kernels/kernels.h"

namespace vdisp::kernels {

inline constexpr Bayer all_patterns[] = {Bayer::rggb, Bayer::bggr, Bayer::grbg, Bayer::gbrg};
inline const char* name(Bayer pattern) { return std::array{"rggb", "bggr", "grbg", "gbrg"}[static_cast<size_t>(pattern)]; }

}  // namespace vdisp::kernels
