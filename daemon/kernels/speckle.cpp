// speckle.cpp: the plain form of the speckle filter, and the joining of bands, which has no other form: it is a few rows.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/kernels/speckle.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace vdisp::kernels {

SpeckleScratch::SpeckleScratch(int columns, int lines) : width(columns), height(lines), words((columns + 63) / 64 + 1) {
  const size_t runs = static_cast<size_t>(first_run(height));
  rows = std::make_unique<Row[]>(static_cast<size_t>(height));
  // Not written: memory that no image asks for is never touched.
  parent.reset(new int32_t[runs]);
  area.reset(new int32_t[runs]);
  begin.reset(new uint16_t[runs]);
  end.reset(new uint16_t[runs]);
  bits.reset(new uint64_t[static_cast<size_t>(height) * 8 * words]);
  crossings.reset(new uint16_t[runs]);
}

namespace plain {
namespace {

bool joined(int a, int b, const SpeckleRule& rule) { return a >= rule.least && b >= rule.least && std::abs(a - b) <= rule.max_difference; }

int32_t find(int32_t* parent, int32_t run) {
  while (parent[run] != run) run = parent[run] = parent[parent[run]];
  return run;
}

/// Makes one tree of two; the root is the smaller index, so that parents come before their children.
void unite(SpeckleScratch& s, int32_t a, int32_t b) {
  a = find(s.parent.get(), a);
  b = find(s.parent.get(), b);
  if (a == b) return;
  if (b < a) std::swap(a, b);
  s.parent[b] = a;
  s.area[a] += s.area[b];
}

/// Calls body(run, run above) for the runs of row y and of the row above of which two pixels are joined.
template <class Body>
void each_joined(Plane<const int16_t> in, const SpeckleRule& rule, int y, const SpeckleScratch& s, Body body) {
  const int16_t* here = in.row(y);
  const int16_t* above = in.row(y - 1);
  int32_t next = s.rows[y - 1].first;
  for (int32_t run = s.rows[y].first; run < s.rows[y].last; ++run) {
    while (next < s.rows[y - 1].last && s.end[next] <= s.begin[run]) ++next;
    for (int32_t other = next; other < s.rows[y - 1].last && s.begin[other] < s.end[run]; ++other) {
      int x = std::max(s.begin[run], s.begin[other]);
      const int end = std::min(s.end[run], s.end[other]);
      while (x < end && !joined(here[x], above[x], rule)) ++x;
      if (x < end) body(run, other);
    }
  }
}

// Between bands the trees stay as they are, since other threads will read them. Where the region of a root goes on in another band, the
// root's `area` names the other root instead: ~other, below 0.
int32_t find_joined(int32_t* area, int32_t root) {
  while (area[root] < 0) {
    const int32_t other = ~area[root];
    if (area[other] < 0) area[root] = area[other];
    root = other;
  }
  return root;
}

void unite_bands(SpeckleScratch& s, int32_t run, int32_t other) {
  const int32_t a = find_joined(s.area.get(), s.parent[run]), b = find_joined(s.area.get(), s.parent[other]);
  if (a == b) return;
  s.area[std::min(a, b)] += s.area[std::max(a, b)];
  s.area[std::max(a, b)] = ~std::min(a, b);
}

}  // namespace

void speckle_label(Plane<const int16_t> in, const SpeckleRule& rule, int first, int last, SpeckleScratch& s) {
  int32_t run = s.first_run(first);
  for (int y = first; y < last; ++y) {
    const int16_t* row = in.row(y);
    s.rows[y] = {run, run, y == first};
    for (int x = 0; x < in.width;) {
      const int begin = x++;
      if (row[begin] < rule.least) continue;
      while (x < in.width && joined(row[x - 1], row[x], rule)) ++x;
      s.parent[run] = run;
      s.area[run] = x - begin;
      s.begin[run] = static_cast<uint16_t>(begin);
      s.end[run++] = static_cast<uint16_t>(x);
    }
    s.rows[y].last = run;
    if (y > first) each_joined(in, rule, y, s, [&](int32_t a, int32_t b) { unite(s, a, b); });
  }
  for (int32_t i = s.first_run(first); i < run; ++i) s.parent[i] = s.parent[s.parent[i]];
}

void speckle_join(Plane<const int16_t> in, const SpeckleRule& rule, SpeckleScratch& s) {
  const auto each_border = [&](auto body) {
    for (int y = 1; y < in.height; ++y) {
      if (s.rows[y].apart) body(y);
    }
  };
  const auto each_joined_root = [&](auto body) {
    each_border([&](int y) {
      for (int row : {y - 1, y}) {
        for (int32_t run = s.rows[row].first; run < s.rows[row].last; ++run) {
          if (s.area[s.parent[run]] < 0) body(s.area[s.parent[run]]);
        }
      }
    });
  };
  each_border([&](int y) { each_joined(in, rule, y, s, [&](int32_t a, int32_t b) { unite_bands(s, a, b); }); });
  each_joined_root([&](int32_t& area) { area = ~find_joined(s.area.get(), ~area); });
  each_joined_root([&](int32_t& area) { area = s.area[~area]; });
}

void speckle_refuse(const SpeckleRule& rule, int first, int last, SpeckleScratch& s, Plane<int16_t> out) {
  for (int y = first; y < last; ++y) {
    int16_t* row = out.row(y);
    for (int32_t run = s.rows[y].first; run < s.rows[y].last; ++run) {
      if (s.area[s.parent[run]] <= rule.max_size) std::fill(row + s.begin[run], row + s.end[run], rule.refused);
    }
  }
}

}  // namespace plain
}  // namespace vdisp::kernels
