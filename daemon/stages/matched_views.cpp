// matched_views.cpp: views to codes by bands of rows.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/matched_views.h"

#include <algorithm>

namespace vdisp {
namespace {

constexpr int log_window = 9;

kernels::View8 view_of(const Image& image) {
  return {image.row<uint8_t>(0), image.spec.width, image.spec.height, static_cast<ptrdiff_t>(image.spec.stride())};
}

}  // namespace

MatchedViews::MatchedViews(Machine& machine, const Config& config)
    : machine_(machine), code_([&p = config.image_source] {
        if (p.matcher == "census") return p.census == "5x5" ? Code::census5x5 : Code::census3x3;
        return p.prefilter == "log" ? Code::log : Code::sobel;
      }()) {}

void MatchedViews::Codes::resize(int width, int height, int margin, bool has_two) {
  const ptrdiff_t stride = (width + margin + 63) / 64 * 64;
  const size_t bytes = static_cast<size_t>(stride) * height;
  memory.assign(has_two ? 2 * bytes : bytes, uint8_t{gradient_cap});
  one = two = {memory.data(), width, height, stride};
  if (has_two) two.data += bytes;
}

void MatchedViews::prepare(const ImageSpec& spec) {
  const bool two = code_ == Code::census5x5;
  for (Codes* codes : {&left_, &unmirrored_}) codes->resize(spec.width, spec.height, 0, two);
  for (Codes* codes : {&right_, &sheared_}) codes->resize(spec.width, spec.height, kernels::mirrored_margin, two);
  for (Codes* codes : {&moved_, &gradient_}) codes->resize(spec.width, spec.height, 0, false);
}

void MatchedViews::encode(kernels::View8 view, int first, int last, Codes& codes) noexcept {
  const auto& k = machine_.kernels;
  switch (code_) {
    case Code::sobel: return k.x_sobel(view, gradient_cap, first, last, codes.one);
    case Code::log: return k.log_filter(view, log_window, gradient_cap, first, last, codes.one);
    case Code::census3x3: return k.census3x3(view, first, last, codes.one);
    case Code::census5x5: return k.census5x5(view, first, last, codes.one, codes.two);
  }
}

void MatchedViews::mirror(int first, int last, Codes& codes) noexcept {
  const auto& k = machine_.kernels;
  for (int v = first; v < last; ++v) {
    k.mirror_row(unmirrored_.one.row(v), codes.one.width, codes.one.row(v));
    if (code_ == Code::census5x5) k.mirror_row(unmirrored_.two.row(v), codes.two.width, codes.two.row(v));
  }
}

/// Rows above its own that a code is made of.
int MatchedViews::rows_above() const {
  switch (code_) {
    case Code::log: return log_window / 2;
    case Code::sobel:
    case Code::census3x3: return 1;
    case Code::census5x5: return 2;
  }
  return 0;
}

void MatchedViews::take(const Image& left, const Image& right) noexcept {
  machine_.bands.run(left.spec.height, least_band, [&](int first, int last, int) {
    encode(view_of(left), first, last, left_);
    if (code_ != Code::sobel) machine_.kernels.x_sobel(view_of(left), gradient_cap, first, last, gradient_.one);
    encode(view_of(right), first, last, unmirrored_);
    mirror(first, last, right_);
  });
}

void MatchedViews::take_sheared(const Image& right, const ExpectedFloor& floor, int first_row) noexcept {
  const int height = right.spec.height, from = std::max(first_row - rows_above(), 0);
  machine_.bands.run(height - from, least_band, [&](int first, int last, int) {
    for (int v = from + first; v < from + last; ++v)
      machine_.kernels.shear_row(right.row<uint8_t>(v), right.spec.width, floor.row(v), moved_.one.row(v));
  });
  // The code of a row needs its neighbours.
  machine_.bands.run(height - first_row, least_band, [&](int first, int last, int) {
    encode(moved_.one, first_row + first, first_row + last, unmirrored_);
    mirror(first_row + first, first_row + last, sheared_);
  });
}

void MatchedViews::put(kernels::BlockSearch& search, const Codes& right) const {
  search.cost = kernels::Cost::hamming;
  if (code_ == Code::sobel || code_ == Code::log) search.cost = kernels::Cost::differences;
  if (code_ == Code::census5x5) search.cost = kernels::Cost::hamming_two;
  search.left = left_.one;
  search.left_more = left_.two;
  search.right = right.one;
  search.right_more = right.two;
}

}  // namespace vdisp
