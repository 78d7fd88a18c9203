// cross_check.cpp: two answers, and what they were before.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/cross_check.h"

namespace vdisp {

std::vector<ImageSpec> CompareWays::check(std::span<const ImageSpec> in) {
  ways_.prepare(in);
  if (!ways_.has_map() || !ways_.has_snow()) throw FormatError("takes what both detectors see, was given one");
  return {record_spec<CrossCheck>()};
}

Outcome CompareWays::process(std::span<const Image* const> in, std::span<Image* const> out) noexcept {
  const MapWay map = ways_.map(in);
  const Way snow = ways_.snow(in);
  const int64_t now_ns = in[0]->timestamp_ns;
  const bool agree = map.free == snow.free;
  (agree ? agreed_ : map.free ? only_map_free_ : only_snow_free_) += 1;
  if (!disagrees_ || now_ns < since_ns_) since_ns_ = now_ns;
  disagrees_ = !agree;
  CrossCheck& check = make_record<CrossCheck>(*out[0]);
  check.agree = agree;
  check.map_free = map.free;
  check.snow_free = snow.free;
  check.corridor_m = map.corridor_m;
  check.disagreeing_s = agree ? 0 : static_cast<double>(now_ns - since_ns_) * 1e-9;
  check.agreed = agreed_;
  check.only_map_free = only_map_free_;
  check.only_snow_free = only_snow_free_;
  return Outcome::valid;
}

}  // namespace vdisp
