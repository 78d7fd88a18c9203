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
  no_imu_ = std::make_unique<BufferOutlet>(record_spec<Imu>());
  make_record<Imu>(no_imu_->loan());
  no_imu_->loan().set_blind(Reason::no_imu);
  plane_.check(std::array{disparity, ImageSpec{Pixel::gray8, 0, disparity.width, disparity.height}, record_spec<Imu>()});
}

const FloorModel* ProvisionalFloor::find(const Image& disparity) noexcept {
  Image &votes = votes_->loan(), &line = line_->loan(), &model = model_->loan();
  for (Image* image : {&votes, &line, &model}) image->describe_like(disparity);
  vdisparity_.filter(disparity, votes);
  const std::array<const Image*, 1> in{&votes};
  const std::array<Image*, 2> out{&line, &model};
  return floor_.process(in, out) == Outcome::valid ? model.row<FloorModel>(0) : nullptr;
}

const FloorModel* ProvisionalFloor::find(const Image& disparity, const Image& left) noexcept {
  if (line_only_) return find(disparity);
  Image &line = line_->loan(), &model = model_->loan();
  for (Image* image : {&line, &model}) image->describe_like(disparity);
  plane_.begin_anew();
  const std::array<const Image*, 3> in{&disparity, &left, &no_imu_->loan()};
  const std::array<Image*, 2> out{&line, &model};
  return plane_.process(in, out) == Outcome::valid ? model.row<FloorModel>(0) : nullptr;
}

}  // namespace vdisp
