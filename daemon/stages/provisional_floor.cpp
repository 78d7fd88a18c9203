// provisional_floor.cpp: v-disparity and line of matches that are not final.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/provisional_floor.h"

#include <array>

namespace vdisp {

void ProvisionalFloor::prepare(const ImageSpec& disparity) {
  const ImageSpec votes = vdisparity_.accept(disparity);
  votes_ = std::make_unique<BufferOutlet>(votes);
  const auto floor = floor_.check(std::array{votes});
  line_ = std::make_unique<BufferOutlet>(floor[0]);
  model_ = std::make_unique<BufferOutlet>(floor[1]);
}

const FloorModel* ProvisionalFloor::find(const Image& disparity) noexcept {
  Image &votes = votes_->loan(), &line = line_->loan(), &model = model_->loan();
  for (Image* image : {&votes, &line, &model}) image->describe_like(disparity);
  vdisparity_.filter(disparity, votes);
  const std::array<const Image*, 1> in{&votes};
  const std::array<Image*, 2> out{&line, &model};
  return floor_.process(in, out) == Outcome::valid ? model.row<FloorModel>(0) : nullptr;
}

}  // namespace vdisp
