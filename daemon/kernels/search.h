// search.h: which raw disparities count, and which column of the v-disparity each belongs to.
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace vdisp::kernels {

/// A disparity d (1/16 px) counts when least <= d < end(); its column is d - first. What is rejected lies below all of them:
/// -32000 <= first <= least <= end() <= 32767.
struct Search {
  int first, least, columns;

  int end() const { return first + columns; }
  bool counts(int d) const { return d >= least && d < end(); }
};

}  // namespace vdisp::kernels
