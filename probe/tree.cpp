// tree.cpp: from parents by number to lines with branches.
// SPDX-License-Identifier: Apache-2.0
#include "probe/tree.h"

#include "probe/attach.h"

namespace vdisp {
namespace {

struct Builder {
  std::span<const CatalogueEntry> entries;
  bool ascii;
  std::vector<TreeLine> lines;

  bool known(int parent) const { return parent >= 0 && parent < static_cast<int>(entries.size()); }

  // Inputs come before what is made of them; anything else in the catalogue is shown as a root, so that no loop is possible.
  int parent_of(size_t entry) const {
    const int parent = entries[entry].parents[0];
    return known(parent) && parent < static_cast<int>(entry) ? parent : -1;
  }

  std::string also(size_t entry) const {
    std::string text;
    for (size_t i = 1; i < std::size(entries[entry].parents); ++i) {
      const int parent = entries[entry].parents[i], of_last = delayed_parent(parent);
      const std::string before = text.empty() ? "+ " : ", ";
      if (known(parent)) text += before + std::string(name_of(entries[parent]));
      if (known(of_last)) text += before + "last " + std::string(name_of(entries[of_last]));
    }
    return text;
  }

  void add_children(int parent, const std::string& indent) {
    std::vector<size_t> children;
    for (size_t i = 0; i < entries.size(); ++i) {
      if (parent_of(i) == parent) children.push_back(i);
    }
    for (size_t child : children) {
      const bool last = child == children.back(), root = parent < 0;
      const std::string corner = root ? "" : ascii ? (last ? "`-" : "|-") : (last ? "└─" : "├─");
      lines.push_back({child, indent + corner, also(child)});
      add_children(static_cast<int>(child), root ? "" : indent + (last ? "  " : ascii ? "| " : "│ "));
    }
  }
};

}  // namespace

std::vector<TreeLine> tree_of(std::span<const CatalogueEntry> entries, bool ascii) {
  Builder builder{entries, ascii, {}};
  builder.add_children(-1, "");
  return builder.lines;
}

}  // namespace vdisp
