// smoothing.h: part of `disparity`: takes noise off both views before they are matched.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>

#include "config/config.h"
#include "daemon/stages/machine.h"
#include "ipc/outlet.h"

namespace vdisp {

/// As the second paper does with mean or median filters (Kueblbeck, Ach, Ernst 2005, 1.1), for every matcher.
class Smoothing {
 public:
  Smoothing(Machine& machine, const Config& config) : machine_(machine), config_(config) {}
  /// Reserves memory for images of this size.
  void prepare(const ImageSpec& spec);
  /// Left and right as `smooth` asks for: smoothed, until the next call; or as they are.
  std::array<const Image*, 2> smooth(const Image& left, const Image& right) noexcept;

 private:
  Machine& machine_;
  const Config& config_;
  std::array<std::optional<BufferOutlet>, 2> smoothed_;
};

}  // namespace vdisp
