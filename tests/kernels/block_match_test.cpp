// block_match_test.cpp: block matching is the same at every level, equals sums written out, and stays inside its planes.
// SPDX-License-Identifier: Apache-2.0
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

TEST(MatchRow, finds_the_least_of_sums_written_out) {
  const Pair pair(60, 9, Content::noise, 62);
  const BlockSearch s = pair.search(Cost::differences, 5, 16, 0);
  BlockScratch scratch(60, 16);
  Rows rows(60);
  plain::match_row(s, 4, true, scratch, rows.row());
  for (int x = s.first_column(); x < s.last_column(); ++x) {
    int best = -1, least = 1 << 20;
    for (int d = 0; d < 16; ++d) {
      int sum = 0;
      for (int y = 2; y <= 6; ++y)
        for (int u = x - 2; u <= x + 2; ++u) sum += std::min(std::abs(s.left.row(y)[u] - s.right.row(y)[59 - u + d]), s.cap);
      if (sum < least) least = sum, best = d;
    }
    EXPECT_EQ(rows.row().index[x], best) << x;
    EXPECT_EQ(rows.row().cost[x], least) << x;
  }
}

}  // namespace
}  // namespace vdisp::kernels
