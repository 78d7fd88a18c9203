// block_match_test.cpp: block matching is the same at every level, equals sums written out, and stays inside its planes.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>

#include "tests/kernels/check.h"

namespace vdisp::kernels {
namespace {

struct Rows {
  explicit Rows(int width) : data(static_cast<size_t>(6 * (width + row_margin)), 0xABCD), width_(width + row_margin) {}
  Candidates row() {
    uint16_t* p = data.data();
    return {p, p + width_, p + 2 * width_, p + 3 * width_, p + 4 * width_, p + 5 * width_};
  }
  /// The columns [from, to) of all six.
  std::vector<uint16_t> columns(int from, int to) const {
    std::vector<uint16_t> all;
    for (int i = 0; i < 6 && to > from; ++i) all.insert(all.end(), data.begin() + i * width_ + from, data.begin() + i * width_ + to);
    return all;
  }
  std::vector<uint16_t> data;
  int width_;
};

/// A left view, and a right one that is the left moved by 5 px with some noise, mirrored.
struct Pair {
  Pair(int width, int height, Content content, uint8_t most)
      : left(width, height),
        right(width, height, mirrored_margin + 3),
        left_more(width, height),
        right_more(width, height, mirrored_margin) {
    fill(left, content, 7, most);
    fill(left_more, Content::noise, 8, static_cast<uint8_t>(15));
    fill(right_more, Content::noise, 9, static_cast<uint8_t>(15));
    std::minstd_rand random(3);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        right.at(width - 1 - x, y) =
            static_cast<uint8_t>(std::min<int>(most, left.at(std::min(x + 5, width - 1), y) + static_cast<int>((random() >> 8) % 3)));
  }
  BlockSearch search(Cost cost, int window, int disparities, int least) const {
    BlockSearch s;
    s.cost = cost;
    s.window = window;
    s.unique = s.left_right = percent_factor(10);
    s.cap = 255 / window;
    s.disparities = disparities;
    s.min_disparity = least;
    s.home = window == 11 ? 8 : -1;
    s.left = left.view();
    s.right = right.view();
    s.left_more = left_more.view();
    s.right_more = right_more.view();
    return s;
  }
  Picture<uint8_t> left, right, left_more, right_more;
};

void compare_rows(MatchRow* expected, MatchRow* got, const BlockSearch& s) {
  BlockScratch one(s.left.width, s.disparities), two(s.left.width, s.disparities);
  Rows a(s.left.width), b(s.left.width);
  const int r = s.window / 2;
  for (int y = r; y < s.left.height - r; ++y) {
    const bool fresh = y == r || y == s.left.height / 2;
    expected(s, y, fresh, one, a.row());
    got(s, y, fresh, two, b.row());
    ASSERT_EQ(a.columns(s.first_column(), s.last_column()), b.columns(s.first_column(), s.last_column()))
        << "row " << y << " window " << s.window << " disparities " << s.disparities << " from " << s.min_disparity;
  }
}

TEST(MatchRow, is_the_same_at_every_level) {
  at_each_level([](const std::string&, const Kernels& k) {
    for (Content content : all_contents) {
      const Pair pair(170, 26, content, 62);
      for (int window : {5, 11, 21}) {
        for (int disparities : {16, 32, 48, 64, 80, 128}) {
          for (int least : {0, -9, 7})
            compare_rows(plain::match_row, k.match_row, pair.search(Cost::differences, window, disparities, least));
        }
      }
    }
  });
}

TEST(MatchRow, is_the_same_at_every_level_for_census_codes) {
  at_each_level([](const std::string&, const Kernels& k) {
    for (Content content : {Content::noise, Content::stripes, Content::white}) {
      const Pair pair(121, 24, content, 255);
      for (Cost cost : {Cost::hamming, Cost::hamming_two})
        for (int disparities : {16, 48, 64}) compare_rows(plain::match_row, k.match_row, pair.search(cost, 21, disparities, 0));
    }
  });
}

TEST(MatchRow, is_the_same_for_the_widest_search_and_the_narrowest_image) {
  at_each_level([](const std::string&, const Kernels& k) {
    const Pair wide(300, 13, Content::noise, 62);
    compare_rows(plain::match_row, k.match_row, wide.search(Cost::differences, 11, 256, 0));
    for (int width : {1, 11, 26, 27, 28, 29}) {
      const Pair narrow(width, 12, Content::noise, 62);
      compare_rows(plain::match_row, k.match_row, narrow.search(Cost::differences, 11, 16, 0));
    }
  });
}

/// What the contract says of one row, each sum written out.
struct Truth {
  Truth(const BlockSearch& search, int row) : s(search), y(row) {}

  int cost(int x, int d) const {
    int sum = 0;
    const int r = s.window / 2;
    for (int v = y - r; v <= y + r; ++v) {
      for (int u = x - r; u <= x + r; ++u) {
        const int there = s.left.width - 1 - u + d;
        const auto differ = [&](View8 l, View8 right) { return std::popcount(static_cast<unsigned>(l.row(v)[u] ^ right.row(v)[there])); };
        if (s.cost == Cost::differences) sum += std::min(std::abs(s.left.row(v)[u] - s.right.row(v)[there]), s.cap);
        if (s.cost != Cost::differences) sum += differ(s.left, s.right);
        if (s.cost == Cost::hamming_two) sum += differ(s.left_more, s.right_more);
      }
    }
    return sum;
  }
  bool searched(int x, int i) const { return x >= s.first_column() && x < s.last_column() && i >= 0 && i < s.disparities; }
  int at(int x, int i) const { return cost(x, s.min_disparity + i); }
  int best(int x) const {
    int found = 0;
    for (int i = 1; i < s.disparities; ++i)
      if (at(x, i) < at(x, found)) found = i;
    return found;
  }
  uint16_t refused(int x, int index) const {
    const auto part = [](int c, int factor) { return c + static_cast<int>(int64_t{c} * factor / 65536); };
    uint16_t bits = 0;
    const int least = at(x, index);
    for (int i = 0; s.unique > 0 && i < s.disparities; ++i)
      if (std::abs(i - index) > 1 && at(x, i) <= part(least, s.unique)) bits |= candidate_not_unique;
    // All pixels of the left view that can meet the same pixel of the right one.
    int match = least, elsewhere = least;
    for (int step = -s.disparities; step <= s.disparities; ++step) {
      if (!searched(x + step, index + step)) continue;
      const int other = at(x + step, index + step);
      elsewhere = std::min(elsewhere, other);
      if (std::abs(step) == 1) match = std::min(match, other);
    }
    if (part(elsewhere, s.left_right) < match) bits |= candidate_left_right;
    return bits;
  }
  const BlockSearch& s;
  int y;
};

void compare_with_truth(const Kernels& k, const BlockSearch& s) {
  BlockScratch scratch(s.left.width, s.disparities);
  Rows rows(s.left.width);
  const int y = s.window / 2 + 1;
  k.match_row(s, y - 1, true, scratch, rows.row());
  k.match_row(s, y, false, scratch, rows.row());
  const Candidates got = rows.row();
  const Truth truth(s, y);
  ASSERT_LT(s.first_column(), s.last_column());
  for (int x = s.first_column(); x < s.last_column(); ++x) {
    SCOPED_TRACE("column " + std::to_string(x));
    const int i = truth.best(x), last = s.disparities - 1;
    ASSERT_EQ(got.index[x], i);
    ASSERT_EQ(got.cost[x], truth.at(x, i));
    ASSERT_EQ(got.before[x], truth.at(x, i > 0 ? i - 1 : 1));
    ASSERT_EQ(got.after[x], truth.at(x, i < last ? i + 1 : last - 1));
    ASSERT_EQ(got.refused[x], truth.refused(x, i));
    if (s.home > 0) {
      ASSERT_EQ(got.home[x], std::min({truth.at(x, s.home - 1), truth.at(x, s.home), truth.at(x, s.home + 1)}));
    }
  }
}

TEST(MatchRow, is_what_sums_written_out_give_at_every_level) {
  for (const std::string& level : levels()) {
    const Kernels k = kernels(level);
    for (Content content : {Content::noise, Content::few_levels, Content::stripes}) {
      const Pair pair(60, 9, content, 62);
      for (Cost cost : {Cost::differences, Cost::hamming, Cost::hamming_two}) {
        for (int least : {0, 3, -8, -24}) {  // -24 .. -9: wholly below zero
          for (int unique : {0, percent_factor(10), percent_factor(40)}) {
            SCOPED_TRACE(level + " cost " + std::to_string(static_cast<int>(cost)) + " from " + std::to_string(least));
            BlockSearch s = pair.search(cost, 5, 16, least);
            s.home = 8;
            s.unique = unique;
            compare_with_truth(k, s);
            if (testing::Test::HasFatalFailure()) return;
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace vdisp::kernels
