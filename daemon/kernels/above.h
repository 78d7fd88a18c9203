// above.h: the disparities above the limit, row by row: as the rows go down, there are only ever fewer of them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "daemon/kernels/search.h"

namespace vdisp::kernels {

/// After go_to(row): raw disparities [first, end) outside of which nothing is above the limit in this row. Rows are asked for from the
/// top down.
class Above {
 public:
  Above(const Search& search, const int16_t* limit)
      : first(search.least), end(search.end()), origin_(search.first), limit_(limit), solid_(rises_then_falls()) {}
  void go_to(int row) {
    while (first < end && limit_[first - origin_] <= row) ++first;
    while (end > first && limit_[end - 1 - origin_] <= row) --end;
  }
  bool operator()(int row, int d) const { return d >= first && d < end && limit_[d - origin_] > row; }
  /// Everything in [first, end) is above the limit, in every row: so it is where the floor is a line.
  bool solid() const { return solid_; }

  int first, end;

 private:
  bool rises_then_falls() const {
    int d = first + 1;
    while (d < end && limit_[d - 1 - origin_] <= limit_[d - origin_]) ++d;
    while (d < end && limit_[d - 1 - origin_] >= limit_[d - origin_]) ++d;
    return d >= end;
  }

  int origin_;
  const int16_t* limit_;
  bool solid_;
};

}  // namespace vdisp::kernels
