// line_search_test.cpp: points and what lies near a line: the same at every level, and against whole numbers.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/kernels/line_search.h"

#include <cmath>

#include "tests/kernels/check.h"

namespace vdisp::kernels {
namespace {

/// Three lists with guards behind them.
class Lists {
 public:
  explicit Lists(size_t points) : room_(point_room(points)) {
    for (auto& list : lists_) {
      list.assign(room_ + 8, 0);
      std::fill(list.end() - 8, list.end(), -7.5f);
    }
  }
  Points points() { return {lists_[0].data(), lists_[1].data(), lists_[2].data()}; }
  void put(size_t i, int column, int row, int votes) {
    lists_[0][i] = static_cast<float>(column);
    lists_[1][i] = static_cast<float>(row);
    lists_[2][i] = static_cast<float>(votes);
  }
  bool same(const Lists& other, size_t n) const {
    for (size_t k = 0; k < 3; ++k)
      if (!std::equal(lists_[k].begin(), lists_[k].begin() + static_cast<ptrdiff_t>(n), other.lists_[k].begin())) return false;
    return true;
  }
  bool damaged() const {
    for (const auto& list : lists_)
      for (size_t i = room_; i < list.size(); ++i)
        if (list[i] != -7.5f) return true;
    return false;
  }

 private:
  size_t room_;
  std::vector<float> lists_[3];
};

Lists cloud(size_t n, uint32_t seed) {
  Lists lists(n);
  std::minstd_rand random(seed + 1);
  for (size_t i = 0; i < n; ++i) {
    const int column = static_cast<int>(random() % 4096), row = static_cast<int>(random() % 2000);
    const bool on_line = random() % 2;
    lists.put(i, column, on_line ? (column + 300) / 2 : row, static_cast<int>(1 + random() % 640));
  }
  return lists;
}

constexpr size_t counts[] = {0, 1, 2, 3, 7, 8, 15, 16, 17, 31, 33, 64, 511, 512, 513, 1024, 1029, 5000};

TEST(CollectPoints, is_the_same_at_every_level) {
  at_each_level([](const std::string&, const Kernels& k) {
    for (const auto& [width, height] : awkward_sizes) {
      for (Content content : all_contents) {
        for (int threshold : {0, 3, 100, 32766}) {
          Picture<int16_t> votes(width, height);
          fill(votes, content, static_cast<uint32_t>(width), threshold == 32766 ? int16_t{32767} : int16_t{6});
          const size_t cells = static_cast<size_t>(width) * static_cast<size_t>(height);
          Lists expected(cells), got(cells);
          const size_t n = plain::collect_points(votes.view(), threshold, expected.points());
          ASSERT_EQ(k.collect_points(votes.view(), threshold, got.points()), n) << width << "x" << height;
          ASSERT_TRUE(got.same(expected, n)) << width << "x" << height << " threshold " << threshold;
          ASSERT_FALSE(got.damaged());
        }
      }
    }
  });
}

TEST(CollectPoints, lists_cells_with_more_votes_than_the_threshold_row_by_row) {
  Picture<int16_t> votes(100, 4);
  fill(votes, Content::black, 1);
  votes.at(99, 1) = 4;
  votes.at(40, 1) = 3;
  votes.at(0, 3) = 32767;
  votes.at(50, 1) = 5;
  Lists expected(3);
  expected.put(0, 50, 1, 5);
  expected.put(1, 99, 1, 4);
  expected.put(2, 0, 3, 32767);
  const auto check = [&](const Kernels& k) {
    Lists got(400);
    ASSERT_EQ(k.collect_points(votes.view(), 3, got.points()), 3u);
    EXPECT_TRUE(got.same(expected, 3));
  };
  check(kernels("plain"));
  at_each_level([&](const std::string&, const Kernels& k) { check(k); });
}

TEST(CountNear, is_the_same_at_every_level) {
  at_each_level([](const std::string&, const Kernels& k) {
    for (size_t n : counts) {
      Lists lists = cloud(n, static_cast<uint32_t>(n));
      for (float slope : {0.5f, 0.1f, 1.26f, 0.4999999f}) {
        for (float reach : {0.1f, 4.0f, 4.4721f, 500.0f}) {
          const size_t exact = plain::count_near(lists.points(), n, slope, 150, reach, 0);
          ASSERT_EQ(k.count_near(lists.points(), n, slope, 150, reach, 0), exact) << n;
          for (size_t beat : {exact - 1, exact, exact + 1, n}) {
            if (beat > n) continue;
            ASSERT_EQ(k.count_near(lists.points(), n, slope, 150, reach, beat), exact > beat ? exact : 0) << n << " beat " << beat;
          }
        }
      }
    }
  });
}

TEST(CountNear, what_lies_at_the_reach_is_not_near) {
  Lists lists(9);
  for (int i = 0; i < 9; ++i) lists.put(static_cast<size_t>(i), 10, 15 + i, 1);  // the line is at 19.5 there
  const auto check = [&](const Kernels& k) {
    EXPECT_EQ(k.count_near(lists.points(), 9, 0.5f, 14.5f, 2.5f, 0), 4u);
    EXPECT_EQ(k.count_near(lists.points(), 9, 0.5f, 14.5f, 2.501f, 0), 6u);
  };
  check(kernels("plain"));
  at_each_level([&](const std::string&, const Kernels& k) { check(k); });
}

TEST(SumNear, is_exact_at_every_level) {
  for (size_t n : counts) {
    Lists lists = cloud(n, static_cast<uint32_t>(n) + 9);
    const Points p = lists.points();
    for (double reach : {0.3, 4.4721, 1e9}) {
      int64_t sums[7] = {};
      for (size_t i = 0; i < n; ++i) {
        const auto column = static_cast<int64_t>(p.column[i]), row = static_cast<int64_t>(p.row[i]),
                   votes = static_cast<int64_t>(p.votes[i]);
        sums[1] += votes;
        if (std::abs(0.5 * static_cast<double>(column) + 150 - static_cast<double>(row)) >= reach) continue;
        const int64_t terms[] = {1, 0, votes, votes * column, votes * row, votes * column * column, votes * column * row};
        for (size_t s = 0; s < 7; ++s) sums[s] += terms[s];
      }
      const auto number = [&](int s) { return static_cast<double>(sums[s]); };
      const NearSums expected{number(0), number(1), number(2), number(3), number(4), number(5), number(6)};
      const auto check = [&](const Kernels& k) { ASSERT_EQ(k.sum_near(p, n, 0.5, 150, reach), expected) << n << " reach " << reach; };
      check(kernels("plain"));
      at_each_level([&](const std::string&, const Kernels& k) { check(k); });
    }
  }
}

TEST(SumNear, is_exact_for_the_largest_v_disparity) {
  // Every row of an 8192 x 8192 image has all its votes in the last of 4096 columns.
  Lists lists(8192);
  for (int row = 0; row < 8192; ++row) lists.put(static_cast<size_t>(row), 4095, row, 8192);
  const int64_t votes = 8192LL * 8192, rows = 8192LL * 8191 / 2 * 8192;
  const NearSums expected{8192,
                          static_cast<double>(votes),
                          static_cast<double>(votes),
                          static_cast<double>(votes * 4095),
                          static_cast<double>(rows),
                          static_cast<double>(votes * 4095 * 4095),
                          static_cast<double>(rows * 4095)};
  const auto check = [&](const Kernels& k) { EXPECT_EQ(k.sum_near(lists.points(), 8192, 0, 0, 1e9), expected); };
  check(kernels("plain"));
  at_each_level([&](const std::string&, const Kernels& k) { check(k); });
}

}  // namespace
}  // namespace vdisp::kernels
