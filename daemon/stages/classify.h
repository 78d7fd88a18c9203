// classify.h: stage `snow`: free or obstacle, left or right, as a Sparse Network of Winnows has learned it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "config/config.h"
#include "daemon/core/processor.h"
#include "daemon/snow/model.h"
#include "daemon/stages/steering.h"
#include "ipc/records.h"

namespace vdisp {

/// Features and the left smoothed view (for its size alone) to SnowScores: the scores of both classifiers of the model (census + SNoW, 3).
/// check() throws snow::ModelError where the model cannot be used: no such file, damaged, or trained with another front end than
/// [census] describes.
class Classify final : public ImageProcessor {
 public:
  explicit Classify(const Config& config) : config_(config) {}
  std::vector<ImageSpec> check(std::span<const ImageSpec> in) override;
  Outcome process(std::span<const Image* const> in, std::span<Image* const> out) noexcept override;

 private:
  const Config& config_;
  std::optional<snow::Model> model_;
  snow::Encoding encoding_{};
  std::vector<uint32_t> ids_;
};

/// What the scores say of the way: difference + sensitivity > 0 is free, and left. Its clearness is what it is over 0, of `clear`.
Way way_of(const SnowScores& scores) noexcept;

}  // namespace vdisp
