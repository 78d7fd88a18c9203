// simd.h: what every Highway form of a kernel needs: how its pointer for the chosen instruction set is found.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <hwy/highway.h>

/// Pointer to the form of a HWY_EXPORTed function for the target that kernels() has chosen.
#if (HWY_TARGETS & (HWY_TARGETS - 1)) == 0
#define VDISP_CHOSEN(function) HWY_DISPATCH_TABLE(function)[0]
#else
#define VDISP_CHOSEN(function) HWY_DISPATCH_TABLE(function)[hwy::GetChosenTarget().GetIndex()]
#endif

namespace vdisp::kernels {

struct Kernels;
/// Each writes its kernels into the table, in the form of the chosen target.
void choose_prefilter(Kernels& table);
void choose_vdisparity(Kernels& table);
void choose_line_search(Kernels& table);
void choose_plane_search(Kernels& table);
void choose_height(Kernels& table);
void choose_map(Kernels& table);
void choose_block_match(Kernels& table);
void choose_resolve(Kernels& table);
void choose_shear(Kernels& table);
void choose_texture(Kernels& table);
void choose_smooth(Kernels& table);
void choose_speckle_label(Kernels& table);
void choose_speckle_refuse(Kernels& table);
void choose_sparse_census(Kernels& table);
void choose_paths_across(Kernels& table);
void choose_paths_down(Kernels& table);
void choose_paths_row(Kernels& table);
void choose_rectify(Kernels& table);
void choose_debayer(Kernels& table);
void choose_census(Kernels& table);
void choose_shrink(Kernels& table);
void choose_hamming(Kernels& table);
void choose_depth_map(Kernels& table);

}  // namespace vdisp::kernels
