// kernels.h: the table of hot loops: one pointer a kernel, chosen once for the instruction set of the machine.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "daemon/kernels/block_match.h"
#include "daemon/kernels/census.h"
#include "daemon/kernels/debayer.h"
#include "daemon/kernels/depth_map.h"
#include "daemon/kernels/hamming.h"
#include "daemon/kernels/height.h"
#include "daemon/kernels/line_search.h"
#include "daemon/kernels/map.h"
#include "daemon/kernels/plane_search.h"
#include "daemon/kernels/prefilter.h"
#include "daemon/kernels/rectify.h"
#include "daemon/kernels/resolve.h"
#include "daemon/kernels/semi_global.h"
#include "daemon/kernels/shear.h"
#include "daemon/kernels/shrink.h"
#include "daemon/kernels/smooth.h"
#include "daemon/kernels/speckle.h"
#include "daemon/kernels/texture.h"
#include "daemon/kernels/vdisparity.h"

namespace vdisp::kernels {

/// The contract stands on the type of the pointer. Each kernel gives the same bytes at every level, reads and writes nothing outside
/// what its contract names, and neither allocates nor throws.
struct Kernels {
  XSobel* x_sobel;
  CountVotes* count_votes;
  CollectPoints* collect_points;
  CountNear* count_near;
  SumNear* sum_near;
  CountOnPlane* count_on_plane;
  SumOnPlane* sum_on_plane;
  MeasureHeights* measure_heights;
  MarkAbove* mark_above;
  CountCells* count_cells;
  MatchRow* match_row;
  ResolveRow* resolve_row;
  ShearRow* shear_row;
  MirrorRow* mirror_row;
  TextureRow* texture_row;
  LogFilter* log_filter;
  Smooth3x3 *mean3x3, *median3x3;
  SpeckleLabel* speckle_label;
  SpeckleJoin* speckle_join;
  SpeckleRefuse* speckle_refuse;
  SparseCensus* sparse_census;
  PathsAcross* paths_across;
  PathsDown* paths_down;
  PathsRow* paths_row;
  Rectify* rectify;
  Debayer* debayer;
  Census3x3* census3x3;
  Census5x5* census5x5;
  Shrink* shrink;
  MatchHamming* match_hamming;
  CountDepth* count_depth;
};

/// Levels this machine can run, simplest first: `plain`, then for example `sse4`, `avx2`, `avx512`, `avx512dl`, or `neon`, `sve`.
std::vector<std::string> levels();
/// The kernels of a level; `auto` is the best one. Throws std::invalid_argument naming the levels there are.
/// Call it while building: it is not meant for two threads at once.
Kernels kernels(std::string_view level = "auto");

}  // namespace vdisp::kernels
