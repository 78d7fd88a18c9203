// semi_global_matcher.cpp: census codes, paths group by group of rows, winners row by row.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/semi_global_matcher.h"

#include <algorithm>
#include <string>

namespace vdisp {
namespace {

constexpr int rows_across = kernels::SemiGlobalVolume::rows_across;
constexpr int gradient_cap = 31;       // as in the block matcher
constexpr int left_right_margin = 60;  // percent: sums of paths differ by little from one pixel to the next
constexpr int most_of_path = 40;       // less thresh: a path that costs more found nothing: noise, and what one view alone sees
constexpr int least_of_path = 20;
constexpr int least_band = 8;  // rows

}  // namespace

SemiGlobalMatcher::SemiGlobalMatcher(Machine& machine, const Config& config)
    : machine_(machine), config_(config), paths_(std::stoi(config.image_source.paths)) {}

void SemiGlobalMatcher::Codes::resize(const ImageSpec& spec) {
  const ptrdiff_t stride = (spec.width + kernels::codes_margin + 63) / 64 * 64;
  memory.assign(2 * static_cast<size_t>(stride) * static_cast<size_t>(spec.height), 0);
  low = {memory.data(), spec.width, spec.height, stride};
  high = {memory.data() + stride * spec.height, spec.width, spec.height, stride};
}

void SemiGlobalMatcher::prepare(const ImageSpec& spec) {
  left_.resize(spec);
  right_.resize(spec);
  const int threads = machine_.bands.threads(), groups = (spec.height + rows_across - 1) / rows_across;
  const int held = paths_ == 3 ? std::min(threads, groups) : groups;
  volume_ = {spec.width, held * rows_across, config_.image_source.ndisp, paths_, threads};
  row_ = static_cast<size_t>(spec.width + kernels::row_margin);
  candidates_.assign(static_cast<size_t>(threads), std::vector<uint16_t>(5 * row_));
  textures_.assign(static_cast<size_t>(threads), std::vector<uint16_t>(2 * static_cast<size_t>(spec.width + kernels::texture_margin)));
  gradient_memory_.resize(static_cast<size_t>(spec.width) * static_cast<size_t>(spec.height));
  gradient_ = {gradient_memory_.data(), spec.width, spec.height, spec.width};
}

kernels::SemiGlobal SemiGlobalMatcher::search_in(const Image& left) const {
  const auto& p = config_.image_source;
  kernels::SemiGlobal search;
  search.disparities = p.ndisp;
  search.min_disparity = p.minDisparity;
  search.paths = paths_;
  search.unique = kernels::percent_factor(p.unique) / 4;
  search.most = std::min(std::max(most_of_path - p.thresh, least_of_path) * std::min(paths_, 4), 255);
  search.left_right = kernels::percent_factor(left_right_margin);
  search.image = {left.row<uint8_t>(0), left.spec.width, left.spec.height, static_cast<ptrdiff_t>(left.spec.stride())};
  search.left_low = left_.low;
  search.left_high = left_.high;
  search.right_low = right_.low;
  search.right_high = right_.high;
  return search;
}

void SemiGlobalMatcher::encode(const Image& view, Codes& codes) noexcept {
  const kernels::View8 pixels{view.row<uint8_t>(0), view.spec.width, view.spec.height, static_cast<ptrdiff_t>(view.spec.stride())};
  machine_.bands.run(view.spec.height, least_band,
                     [&](int first, int last, int) { machine_.kernels.sparse_census(pixels, first, last, codes.low, codes.high); });
}

void SemiGlobalMatcher::match(const Image& left, const Image& right, Image& out) noexcept {
  encode(left, left_);
  encode(right, right_);
  const kernels::View8 view{left.row<uint8_t>(0), left.spec.width, left.spec.height, static_cast<ptrdiff_t>(left.spec.stride())};
  machine_.bands.run(view.height, least_band,
                     [&](int first, int last, int) { machine_.kernels.x_sobel(view, gradient_cap, first, last, gradient_); });
  const kernels::SemiGlobal search = search_in(left);
  const int height = left.spec.height;
  for (int first = 0; first < height; first += volume_.rows()) {
    const int last = std::min(first + volume_.rows(), height);
    machine_.bands.each((last - first + rows_across - 1) / rows_across, [&](int group, int seat) {
      machine_.kernels.paths_across(search, first + group * rows_across, volume_, volume_.work(seat));
    });
    add_paths(search, first, last, false);
    if (paths_ > 3) add_paths(search, first, last, true);
    choose(search, first, last, out);
  }
}

void SemiGlobalMatcher::add_paths(const kernels::SemiGlobal& search, int first_row, int last_row, bool up) noexcept {
  const int blocks = (search.columns() + kernels::SemiGlobalVolume::block - 1) / kernels::SemiGlobalVolume::block;
  if (paths_ == 8) {
    machine_.kernels.paths_down(search, 0, blocks, first_row, last_row, up, volume_);
  } else {
    machine_.bands.each(blocks, [&](int b, int) { machine_.kernels.paths_down(search, b, b + 1, first_row, last_row, up, volume_); });
  }
}

void SemiGlobalMatcher::choose(const kernels::SemiGlobal& search, int first_row, int last_row, Image& out) noexcept {
  kernels::Resolve resolve{.width = out.spec.width, .min_disparity = search.min_disparity, .disparities = search.disparities};
  const auto& p = config_.image_source;
  const int reach = p.corrsize / 2;
  resolve.texture_least = p.thresh * p.corrsize * p.corrsize / 8;
  resolve.unique = search.unique;
  resolve.outside = rejected(Rejected::outside);
  resolve.low_texture = rejected(Rejected::low_texture);
  resolve.not_unique = rejected(Rejected::not_unique);
  resolve.left_right = rejected(Rejected::left_right);
  machine_.bands.run(last_row - first_row, least_band, [&](int first, int last, int band) {
    uint16_t* row = candidates_[static_cast<size_t>(band)].data();
    const kernels::Hypothesis match{{row, row + row_, row + 2 * row_, row + 3 * row_, row + 4 * row_, nullptr},
                                    std::max(search.first_column(), reach),
                                    std::min(search.last_column(), out.spec.width - reach),
                                    search.min_disparity};
    uint16_t *columns = textures_[static_cast<size_t>(band)].data(), *texture = columns + out.spec.width + kernels::texture_margin;
    int measured = -1;
    for (int v = first_row + first; v < first_row + last; ++v) {
      // Rows at the border have the texture of the nearest row whose window is inside.
      const int row_inside = std::clamp(v, reach, out.spec.height - reach - 1);
      if (row_inside != measured)
        machine_.kernels.texture_row(gradient_, gradient_cap, p.corrsize, row_inside, measured < 0, columns, texture);
      measured = row_inside;
      machine_.kernels.paths_row(search, v, v == first_row + first, volume_, volume_.work(band), match.candidates);
      machine_.kernels.resolve_row(resolve, match, nullptr, {}, texture, out.row<int16_t>(v));
    }
  });
}

}  // namespace vdisp
