// pair_names.h: which files make a stereo pair: the meaning of [image source] left and right where they are images.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace vdisp {

/// literal: one file; pattern: one %d, %6d or %06d for the number; glob: *, ?, [...]. A file of exactly that name is literal,
/// and so are leading folders: br[1]/left/*.png, pc%20/%d.png. Behind them %% is a plain %.
enum class NameForm { literal, pattern, glob };
NameForm form_of(const std::string& name);
/// For messages: "a printf pattern", ...
std::string describe(NameForm form);

struct PairName {
  std::string left, right;
  int64_t recorded_ns = -1;  ///< from a name with 16 digits or more (EuRoC); -1: the names do not tell, for none of the pairs
};

/// The pairs of a recording in their order, at least one; files may be missing.
/// A pattern runs from the least number there is on either side to the greatest. Globs are sorted with numbers in numeric order
/// and paired by what the wildcards stand for, or, where that never agrees, by their order. Throws SourceError: 66 nothing there,
/// 78 not a pattern, or globs that cannot be paired.
std::vector<PairName> list_pairs(const std::string& left, const std::string& right);

}  // namespace vdisp
