// census_view.h: stages `census/left` and `census/right`: the census image of a view.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "daemon/core/processor.h"
#include "daemon/stages/machine.h"

namespace vdisp {

/// gray8 to gray8: each pixel compared with its eight neighbours, a bit set where the centre is brighter (census + SNoW, 2.2 and figure 4).
class CensusView final : public ImageFilter {
 public:
  explicit CensusView(Machine& machine) : machine_(machine) {}
  ImageSpec accept(const ImageSpec& in) override;
  bool filter(const Image& in, Image& out) noexcept override;

 private:
  Machine& machine_;
};

}  // namespace vdisp
