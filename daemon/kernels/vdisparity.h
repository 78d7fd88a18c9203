// vdisparity.h: contract: how often each disparity occurs in each row.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "daemon/kernels/plane.h"
#include "daemon/kernels/search.h"

namespace vdisp::kernels {

/// For rows [first, last): votes[column] = how many pixels of the same row have the disparity of this column, at most 32767; columns
/// from search.columns to votes.width are 0. Other rows are not touched. `scratch` holds vote_scratch(disparity.width) elements. Any
/// rows may be asked for at any time; four or more at once are fastest.
using CountVotes = void(Plane<const int16_t> disparity, int first, int last, const Search& search, Plane<int16_t> votes, uint16_t* scratch);

/// Four rows, each with room for a vector behind it.
constexpr size_t vote_scratch(int width) { return 4 * (static_cast<size_t>(width) + 128); }

namespace plain {
CountVotes count_votes;
}

}  // namespace vdisp::kernels
