// smoothed_view.h: stages `smooth/left` and `smooth/right`: a rectified view made smaller, and its noise taken off.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "config/config.h"
#include "daemon/core/processor.h"
#include "daemon/stages/machine.h"
#include "ipc/outlet.h"

namespace vdisp {

/// gray8 to gray8, [census] scale times smaller by averaging, then the mean or median of 3x3, or neither (census + SNoW, 1.1 and figure
/// 5). The geometry in the header is that of the smaller view.
class SmoothedView final : public ImageFilter {
 public:
  SmoothedView(Machine& machine, const Config& config) : machine_(machine), config_(config) {}
  ImageSpec accept(const ImageSpec& in) override;
  bool filter(const Image& in, Image& out) noexcept override;

 private:
  Machine& machine_;
  const Config& config_;
  std::optional<BufferOutlet> small_;  // between the two steps
};

}  // namespace vdisp
