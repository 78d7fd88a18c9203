// tree.h: the daemon's stages as a tree: each below the first of its inputs, other inputs named.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <vector>

#include "ipc/records.h"

namespace vdisp {

struct TreeLine {
  size_t entry;        ///< index into the catalogue
  std::string branch;  ///< what stands before the name: "| +- "
  std::string also;    ///< its further inputs: "+ right, last floor_model"
};

/// Depth first, children in the catalogue's order. `ascii`: for terminals without UTF-8, and for the window.
std::vector<TreeLine> tree_of(std::span<const CatalogueEntry> entries, bool ascii);

}  // namespace vdisp
