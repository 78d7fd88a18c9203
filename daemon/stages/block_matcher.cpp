// block_matcher.cpp: matches row by row, and resolves.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/block_matcher.h"

#include <algorithm>

namespace vdisp {
namespace {

constexpr int gradient_cap = MatchedViews::gradient_cap;
constexpr int floor_disparities = 16;  // searched around the floor expected
constexpr int floor_margin = 50;       // percent the floor may fit worse than a match off it, and still refuse that
constexpr int left_right_margin = 10;  // percent: where the right view is in doubt itself it refuses nothing

/// `floor` with the columns at the right border up to `last`, whose search around the floor would leave the view: what is off the floor
/// there cannot be told from it.
kernels::Hypothesis with_border(kernels::Hypothesis floor, int last) {
  const kernels::Candidates& c = floor.candidates;
  for (int x = floor.last; x < last; ++x) {
    c.index[x] = floor_disparities / 2;
    c.cost[x] = c.before[x] = c.after[x] = INT16_MAX;
    c.refused[x] = kernels::candidate_not_unique;
    c.home[x] = 0;
  }
  floor.last = last;
  return floor;
}

}  // namespace

void BlockMatcher::prepare(const ImageSpec& spec) {
  views_.prepare(spec);
  row_ = static_cast<size_t>(spec.width + kernels::row_margin);
  bands_.resize(static_cast<size_t>(machine_.bands.threads()));
  for (Band& band : bands_) {
    band.plain = {spec.width, config_.image_source.ndisp};
    band.floor = {spec.width, floor_disparities};
    band.candidates.resize(2 * 6 * row_);
    band.texture.resize(2 * static_cast<size_t>(spec.width + kernels::texture_margin));
  }
}

kernels::BlockSearch BlockMatcher::plain_search() const {
  const auto& p = config_.image_source;
  kernels::BlockSearch search;
  search.window = p.corrsize;
  search.cap = std::min(2 * gradient_cap, 255 / p.corrsize);
  search.disparities = p.ndisp;
  search.min_disparity = p.minDisparity;
  views_.put_plain(search);
  search.unique = kernels::percent_factor(p.unique);
  // Truncated costs of rivals grow less: this gives the density that full ones give at `unique`. What log and census find besides, it
  // would let through with too many errors.
  if (p.matcher == "bm" && p.prefilter == "sobel") search.unique = search.unique * 3 / 4;
  search.left_right = kernels::percent_factor(left_right_margin);
  return search;
}

kernels::BlockSearch BlockMatcher::floor_search() const {
  kernels::BlockSearch search = plain_search();
  search.disparities = floor_disparities;
  search.min_disparity = -floor_disparities / 2;
  search.home = floor_disparities / 2;
  views_.put_sheared(search);
  return search;
}

kernels::Hypothesis BlockMatcher::hypothesis(const kernels::BlockSearch& search, Band& band, int which) const {
  uint16_t* row = band.candidates.data() + which * 6 * row_;
  return {{row, row + row_, row + 2 * row_, row + 3 * row_, row + 4 * row_, row + 5 * row_},
          search.first_column(),
          search.last_column(),
          search.min_disparity};
}

void BlockMatcher::match(const Image& left, const Image& right, const ExpectedFloor* floor, Image& out) noexcept {
  const int height = left.spec.height, reach = config_.image_source.corrsize / 2;
  // Also rows whose floor is too near or too far for the search: what the floor explains better than the match is no match.
  int floor_first = height;
  if (floor) floor_first = std::clamp(floor->first_row(left.spec.width), reach, height);
  views_.take(left, right);
  if (floor_first < height - reach) views_.take_sheared(right, *floor, floor_first - reach);
  machine_.bands.run(height, MatchedViews::least_band, [&](int first, int last, int band) {
    match_band(floor, floor_first, first, last, bands_[static_cast<size_t>(band)], out);
  });
}

void BlockMatcher::match_band(const ExpectedFloor* floor, int floor_first, int first, int last, Band& band, Image& out) noexcept {
  const auto& k = machine_.kernels;
  const auto& p = config_.image_source;
  const int width = out.spec.width, height = out.spec.height, reach = p.corrsize / 2;
  const kernels::BlockSearch plain = plain_search(), aligned = floor_search();
  const kernels::Hypothesis match = hypothesis(plain, band, 0);
  const kernels::Hypothesis ground = hypothesis(aligned, band, 1);
  kernels::Resolve resolve{.width = width, .min_disparity = p.minDisparity, .disparities = p.ndisp};
  const int texture_least = p.thresh * p.corrsize * p.corrsize / 2;
  resolve.unique = plain.unique;
  resolve.floor_margin = kernels::percent_factor(floor_margin);
  resolve.outside = rejected(Rejected::outside);
  resolve.low_texture = rejected(Rejected::low_texture);
  resolve.not_unique = rejected(Rejected::not_unique);
  resolve.left_right = rejected(Rejected::left_right);
  uint16_t *columns = band.texture.data(), *texture = columns + width + kernels::texture_margin;

  bool fresh = true, floor_fresh = true;
  for (int v = first; v < last; ++v) {
    int16_t* row = out.row<int16_t>(v);
    if (v < reach || v >= height - reach) {
      std::fill_n(row, width, resolve.outside);
      continue;
    }
    k.texture_row(views_.gradient(), gradient_cap, p.corrsize, v, fresh, columns, texture);
    k.match_row(plain, v, fresh, band.plain, match.candidates);
    fresh = false;
    // Above the horizon nothing but texture stands against a false match: the noise of a blank sky must not pass by chance.
    resolve.texture_least = floor && v < floor_first ? texture_least * 5 / 4 : texture_least;
    if (v >= floor_first) {
      k.match_row(aligned, v, floor_fresh, band.floor, ground.candidates);
      floor_fresh = false;
      const kernels::Hypothesis whole = with_border(ground, match.last);
      k.resolve_row(resolve, match, &whole, floor->row(v), texture, row);
    } else {
      k.resolve_row(resolve, match, nullptr, {}, texture, row);
    }
  }
}

}  // namespace vdisp
