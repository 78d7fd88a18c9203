// machine.h: what of the machine the stages may use: its threads, and its instruction set.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "daemon/core/bands.h"
#include "daemon/kernels/kernels.h"

namespace vdisp {

/// Made before the tree, and outlives it. Neither changes results, only how soon they are there.
struct Machine {
  /// `cpu`: a level of kernels::levels(), or `auto` for the best. Throws std::invalid_argument, and what Bands throws.
  explicit Machine(int threads = 1, const std::string& cpu = "auto")
      : level(cpu == "auto" ? kernels::levels().back() : cpu), kernels(kernels::kernels(level)), bands(threads) {}

  std::string level;
  kernels::Kernels kernels;
  Bands bands;
};

}  // namespace vdisp
