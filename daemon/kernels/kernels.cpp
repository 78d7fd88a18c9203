// kernels.cpp: the plain kernels, and better ones written over them where the machine has the instructions.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/kernels/kernels.h"

#include <array>
#include <stdexcept>

#include "daemon/kernels/simd.h"

namespace vdisp::kernels {
namespace {

struct Level {
  std::string_view name;
  int64_t target;
};

// Simplest first.
#if HWY_ARCH_X86
constexpr std::array known{Level{"sse4", HWY_SSE4}, Level{"avx2", HWY_AVX2}, Level{"avx512", HWY_AVX3}, Level{"avx512dl", HWY_AVX3_DL}};
#elif HWY_ARCH_ARM
constexpr std::array known{Level{"neon", HWY_NEON}, Level{"sve", HWY_SVE}, Level{"sve256", HWY_SVE_256}, Level{"sve2", HWY_SVE2},
                           Level{"sve2_128", HWY_SVE2_128}};
#else
constexpr std::array<Level, 0> known{};
#endif

Kernels plain_kernels() {
  return {
      .x_sobel = plain::x_sobel,
      .count_votes = plain::count_votes,
      .collect_points = plain::collect_points,
      .count_near = plain::count_near,
      .sum_near = plain::sum_near,
      .count_on_plane = plain::count_on_plane,
      .sum_on_plane = plain::sum_on_plane,
      .measure_heights = plain::measure_heights,
      .mark_above = plain::mark_above,
      .count_cells = plain::count_cells,
      .match_row = plain::match_row,
      .resolve_row = plain::resolve_row,
      .shear_row = plain::shear_row,
      .mirror_row = plain::mirror_row,
      .texture_row = plain::texture_row,
      .log_filter = plain::log_filter,
      .mean3x3 = plain::mean3x3,
      .median3x3 = plain::median3x3,
      .speckle_label = plain::speckle_label,
      .speckle_join = plain::speckle_join,
      .speckle_refuse = plain::speckle_refuse,
      .sparse_census = plain::sparse_census,
      .paths_across = plain::paths_across,
      .paths_down = plain::paths_down,
      .paths_row = plain::paths_row,
      .rectify = plain::rectify,
      .debayer = plain::debayer,
      .census3x3 = plain::census3x3,
      .census5x5 = plain::census5x5,
      .shrink = plain::shrink,
      .match_hamming = plain::match_hamming,
      .count_depth = plain::count_depth,
  };
}

}  // namespace

std::vector<std::string> levels() {
  std::vector<std::string> names{"plain"};
  const int64_t here = hwy::SupportedTargets() & HWY_TARGETS;
  for (const Level& level : known) {
    if (here & level.target) names.emplace_back(level.name);
  }
  return names;
}

Kernels kernels(std::string_view level) {
  Kernels table = plain_kernels();
  const std::vector<std::string> there = levels();
  if (level == "auto") level = there.back();
  if (level == "plain") return table;
  for (const Level& candidate : known) {
    if (candidate.name != level || !(hwy::SupportedTargets() & HWY_TARGETS & candidate.target)) continue;
    hwy::GetChosenTarget().Update(candidate.target);
    choose_prefilter(table);
    choose_vdisparity(table);
    choose_line_search(table);
    choose_plane_search(table);
    choose_height(table);
    choose_map(table);
    choose_block_match(table);
    choose_resolve(table);
    choose_shear(table);
    choose_texture(table);
    choose_smooth(table);
    choose_speckle_label(table);
    choose_speckle_refuse(table);
    choose_sparse_census(table);
    choose_paths_across(table);
    choose_paths_down(table);
    choose_paths_row(table);
    choose_rectify(table);
    choose_debayer(table);
    choose_census(table);
    choose_shrink(table);
    choose_hamming(table);
    choose_depth_map(table);
    return table;
  }
  std::string names;
  for (const std::string& name : there) names += (names.empty() ? "" : ", ") + name;
  throw std::invalid_argument("no instruction set '" + std::string(level) + "' here; there are " + names);
}

}  // namespace vdisp::kernels
