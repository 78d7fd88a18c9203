// semi_global_test.cpp: semi-global matching is the same at every level, stays inside its planes, and does what its paths are for.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "tests/kernels/check.h"

namespace vdisp::kernels {
namespace {

constexpr int rows_across = SemiGlobalVolume::rows_across;

/// A left view and a right one, their codes, and room for the candidates of all rows.
struct Scene {
  Scene(int width, int height)
      : left(width, height),
        right(width, height),
        codes{Picture<uint8_t>(width, height, codes_margin), Picture<uint8_t>(width, height, codes_margin),
              Picture<uint8_t>(width, height, codes_margin), Picture<uint8_t>(width, height, codes_margin)} {}

  /// The right view shows what the left one does, `disparity` px further left.
  void shift_by(int disparity) {
    const Plane<uint8_t> l = left.plane(), r = right.plane();
    for (int y = 0; y < l.height; ++y)
      for (int x = 0; x < l.width; ++x) r.row(y)[x] = l.row(y)[std::min(x + disparity, l.width - 1)];
  }
  void encode(const Kernels& k) {
    const int height = left.view().height;
    k.sparse_census(left.view(), 0, height, codes[0].plane(), codes[1].plane());
    k.sparse_census(right.view(), 0, height, codes[2].plane(), codes[3].plane());
  }
  SemiGlobal search(int disparities, int least, int paths) const {
    SemiGlobal s;
    s.disparities = disparities;
    s.min_disparity = least;
    s.paths = paths;
    s.unique = percent_factor(5);
    s.left_right = percent_factor(10);
    s.most = disparities == 48 ? 30 : 255;
    s.image = left.view();
    s.left_low = codes[0].view();
    s.left_high = codes[1].view();
    s.right_low = codes[2].view();
    s.right_high = codes[3].view();
    return s;
  }
  Picture<uint8_t> left, right, codes[4];
};

/// Candidates of all rows: for each row index, cost, before, after, refused of the columns that have any.
std::vector<std::vector<uint16_t>> match(const Kernels& k, const SemiGlobal& s) {
  const int width = s.image.width, height = s.image.height, blocks = (s.columns() + SemiGlobalVolume::block - 1) / SemiGlobalVolume::block;
  const int groups = (height + rows_across - 1) / rows_across;
  const SemiGlobalVolume volume(width, (s.paths == 3 ? 1 : groups) * rows_across, s.disparities, s.paths, 1);
  std::vector<std::vector<uint16_t>> all;
  for (int first = 0; first < height; first += volume.rows()) {
    const int last = std::min(first + volume.rows(), height);
    for (int row = first; row < last; row += rows_across) k.paths_across(s, row, volume, volume.work(0));
    for (bool up : {false, true}) {
      for (int b = 0; b < blocks && s.paths < 8 && (!up || s.paths > 3); ++b) k.paths_down(s, b, b + 1, first, last, up, volume);
      if (s.paths == 8) k.paths_down(s, 0, blocks, first, last, up, volume);
    }
    for (int row = first; row < last; ++row) {
      const ptrdiff_t step = width + row_margin;
      std::vector<uint16_t> c(static_cast<size_t>(5 * step), 0xABCD);
      k.paths_row(s, row, row == first, volume, volume.work(0),
                  {c.data(), c.data() + step, c.data() + 2 * step, c.data() + 3 * step, c.data() + 4 * step, nullptr});
      std::vector<uint16_t> columns;
      for (int i = 0; i < 5; ++i)
        columns.insert(columns.end(), c.begin() + i * step + s.first_column(), c.begin() + i * step + s.first_column() + s.columns());
      all.push_back(columns);
    }
  }
  return all;
}

TEST(SparseCensus, is_the_same_at_every_level) {
  at_each_level([](const std::string&, const Kernels& k) {
    for (Content content : all_contents) {
      for (const auto& [width, height] : awkward_sizes) {
        Picture<uint8_t> image(width, height), low(width, height), high(width, height), low2(width, height), high2(width, height);
        fill(image, content, 5);
        plain::sparse_census(image.view(), 0, height, low.plane(), high.plane());
        const int middle = height / 2;
        k.sparse_census(image.view(), 0, middle, low2.plane(), high2.plane());
        k.sparse_census(image.view(), middle, height, low2.plane(), high2.plane());
        ASSERT_TRUE(low == low2 && high == high2) << width << "x" << height << " " << low2.damage() << high2.damage();
        ASSERT_EQ(image.damage(), "");
      }
    }
  });
}

TEST(SparseCensus, says_which_of_two_opposite_pixels_is_darker) {
  Picture<uint8_t> image(20, 20), low(20, 20), high(20, 20);
  fill(image, Content::white, 0);
  image.at(11, 10) = 3;  // seen from (10, 10) at (1, 0), the first pair; from (12, 10) it stands opposite of that
  plain::sparse_census(image.view(), 0, 20, low.plane(), high.plane());
  EXPECT_EQ(low.at(10, 10), 1);
  EXPECT_EQ(high.at(10, 10), 0);
  EXPECT_EQ(low.at(12, 10), 0);
  EXPECT_EQ(low.at(9, 10), 2) << "the second pair is two pixels to the side";
  EXPECT_EQ(high.at(12, 8) & 0b100000, 0);
  EXPECT_EQ(high.at(10, 7), 128) << "the last pair is at (1, 3)";
}

TEST(SemiGlobal, is_the_same_at_every_level) {
  for (Content content : {Content::black, Content::checker, Content::ramp, Content::noise, Content::few_levels}) {
    for (const auto& [width, height] : std::vector<std::pair<int, int>>{{100, 37}, {211, 16}, {64, 5}}) {
      Scene scene(width, height);
      fill(scene.left, content, 7);
      fill(scene.right, Content::noise, 8, static_cast<uint8_t>(40));
      if (content != Content::noise) scene.shift_by(4);
      scene.encode(kernels("plain"));
      for (int paths : {3, 4, 8}) {
        for (int disparities : {16, 48, 64}) {
          for (int least : {0, -7, 5}) {
            const SemiGlobal s = scene.search(disparities, least, paths);
            const auto expected = match(kernels("plain"), s);
            at_each_level([&](const std::string&, const Kernels& k) {
              ASSERT_EQ(expected, match(k, s)) << width << "x" << height << " paths " << paths << " of " << disparities << " from "
                                               << least;
            });
          }
        }
      }
      for (const auto& codes : scene.codes) ASSERT_EQ(codes.damage(), "");
    }
  }
}

TEST(SemiGlobal, is_the_same_at_every_level_with_all_disparities) {
  at_each_level([](const std::string&, const Kernels& k) {
    Scene scene(400, 20);
    fill(scene.left, Content::few_levels, 3);
    scene.shift_by(200);
    scene.encode(k);
    for (int paths : {3, 8}) {
      const SemiGlobal s = scene.search(256, 0, paths);
      ASSERT_EQ(match(kernels("plain"), s), match(k, s)) << paths;
    }
  });
}

/// Last blocks with any number of columns, of which the sub-pixel part reaches over the sides and into the block before.
TEST(SemiGlobal, is_the_same_at_every_level_for_any_number_of_columns) {
  for (int columns = 1; columns <= 2 * SemiGlobalVolume::block + 9; ++columns) {
    Scene scene(columns + 15, 3);
    fill(scene.left, Content::noise, static_cast<uint32_t>(columns));
    fill(scene.right, Content::few_levels, static_cast<uint32_t>(columns));
    scene.encode(kernels("plain"));
    for (int paths : {3, 8}) {
      const SemiGlobal s = scene.search(16, 0, paths);
      ASSERT_EQ(s.columns(), columns);
      const auto expected = match(kernels("plain"), s);
      at_each_level(
          [&](const std::string&, const Kernels& k) { ASSERT_EQ(expected, match(k, s)) << columns << " columns, paths " << paths; });
    }
  }
}

/// Two threads' work spaces lie side by side, and so do the states of the blocks.
TEST(SemiGlobal, a_call_writes_its_own_work_space_and_states) {
  for (const std::string& level : levels()) {
    const Kernels k = kernels(level);
    for (const auto& [width, disparities] :
         std::vector<std::pair<int, int>>{{16, 16}, {79, 16}, {128, 16}, {200, 64}, {192, 128}, {320, 256}}) {
      Scene scene(width, rows_across);
      fill(scene.left, Content::noise, 5);
      scene.shift_by(3);
      scene.encode(k);
      const SemiGlobal s = scene.search(disparities, 0, 3);
      const int blocks = (s.columns() + SemiGlobalVolume::block - 1) / SemiGlobalVolume::block;
      const SemiGlobalVolume volume(width, rows_across, disparities, 3, 2);
      const auto bytes = static_cast<size_t>(volume.work(1) - volume.work(0));
      std::fill_n(volume.work(1), bytes, uint8_t{0xA5});
      const auto untouched = [](const uint8_t* from, size_t count) {
        return static_cast<size_t>(std::count(from, from + count, uint8_t{0xA5})) == count;
      };
      k.paths_across(s, 0, volume, volume.work(0));
      EXPECT_TRUE(untouched(volume.work(1), bytes)) << level << " across, " << width << " wide, " << disparities;
      for (int b = 0; b < blocks; ++b) {
        const auto state_bytes = static_cast<size_t>(volume.states(b + 1) - volume.states(b));
        if (b + 1 < blocks) std::fill_n(volume.states(b + 1), state_bytes, uint8_t{0xA5});
        k.paths_down(s, b, b + 1, 0, rows_across, false, volume);
        if (b + 1 < blocks) {
          EXPECT_TRUE(untouched(volume.states(b + 1), state_bytes)) << level << " down, block " << b;
        }
      }
      std::vector<uint16_t> c(5 * static_cast<size_t>(width + row_margin));
      const ptrdiff_t step = width + row_margin;
      for (int row = 0; row < rows_across; ++row)
        k.paths_row(s, row, row == 0, volume, volume.work(0),
                    {c.data(), c.data() + step, c.data() + 2 * step, c.data() + 3 * step, c.data() + 4 * step, nullptr});
      EXPECT_TRUE(untouched(volume.work(1), bytes)) << level << " row, " << width << " wide, " << disparities;
    }
  }
}

/// What the contract says of the numbers for the sub-pixel part, written out from the volume's costs.
TEST(SemiGlobal, sub_pixel_parts_are_of_costs_summed_over_five_columns) {
  Scene scene(100, 8);
  fill(scene.left, Content::noise, 21);
  fill(scene.right, Content::noise, 22);
  for (const std::string& level : levels()) {
    const Kernels k = kernels(level);
    scene.encode(k);
    const SemiGlobal s = scene.search(16, 0, 3);
    const int columns = s.columns(), row = 4;
    const SemiGlobalVolume volume(100, rows_across, 16, 3, 1);
    k.paths_across(s, 0, volume, volume.work(0));
    for (int b = 0; b < 2; ++b) k.paths_down(s, b, b + 1, 0, 8, false, volume);
    const ptrdiff_t step = 100 + row_margin;
    std::vector<uint16_t> c(static_cast<size_t>(5 * step));
    const Candidates got{c.data(), c.data() + step, c.data() + 2 * step, c.data() + 3 * step, c.data() + 4 * step, nullptr};
    k.paths_row(s, row, true, volume, volume.work(0), got);
    const auto summed = [&](int x, int i) {
      int sum = 0;
      for (int tap : {-6, -3, 0, 3, 6}) {
        const int at = std::clamp(x + tap, 0, columns - 1);
        sum += volume.costs(row, at / SemiGlobalVolume::block)[i * SemiGlobalVolume::block + at % SemiGlobalVolume::block];
      }
      return sum;
    };
    for (int x = 0; x < columns; ++x) {
      const int i = got.index[s.first_column() + x];
      const int before = summed(x, i > 0 ? i - 1 : 1), after = summed(x, i < 15 ? i + 1 : 14);
      EXPECT_EQ(got.before[s.first_column() + x], before) << level << " column " << x;
      EXPECT_EQ(got.after[s.first_column() + x], after) << level << " column " << x;
      EXPECT_EQ(got.cost[s.first_column() + x], std::min({summed(x, i), before, after})) << level << " column " << x;
    }
  }
}

TEST(SemiGlobal, image_narrower_than_the_search_has_no_columns) {
  for (const std::string& level : levels()) {
    Scene scene(40, 20);
    fill(scene.left, Content::noise, 3);
    scene.shift_by(3);
    scene.encode(kernels(level));
    const SemiGlobal s = scene.search(48, 0, 3);
    EXPECT_EQ(s.columns(), 0);
    for (const auto& row : match(kernels(level), s)) EXPECT_TRUE(row.empty());
  }
}

TEST(SemiGlobal, finds_a_shift_everywhere_and_refuses_nothing) {
  for (int paths : {3, 4, 8}) {
    Scene scene(150, 40);
    fill(scene.left, Content::noise, 11);
    scene.shift_by(9);
    const Kernels k = kernels("plain");
    scene.encode(k);
    const SemiGlobal s = scene.search(32, 2, paths);
    const int columns = s.columns();
    for (const auto& row : match(k, s)) {
      // At the right side the right view repeats its last column.
      for (int x = 0; x < columns - 9 - 4; ++x) {
        ASSERT_EQ(row[x], 7) << paths;
        ASSERT_EQ(row[4 * columns + x], 0) << paths;
      }
    }
  }
}

/// What a path is for: a blank stretch takes the disparity of what it is part of, here a floor whose texture has a hole.
TEST(SemiGlobal, a_blank_stretch_takes_the_disparity_around_it) {
  for (int paths : {3, 4, 8}) {
    Scene scene(200, 60);
    fill(scene.left, Content::noise, 11);
    for (int y = 20; y < 40; ++y)
      for (int x = 80; x < 120; ++x) scene.left.at(x, y) = 128;
    scene.shift_by(6);
    const Kernels k = kernels("plain");
    scene.encode(k);
    SemiGlobal s = scene.search(16, 0, paths);
    const auto rows = match(k, s);
    for (int x = 90; x < 110; ++x) EXPECT_EQ(rows[30][x - s.first_column()], 6) << paths << " column " << x;
    s.small = s.large = s.large_least = 0;  // without penalties nothing is learnt from others, and of equals the first is taken
    EXPECT_EQ(match(k, s)[30][100 - s.first_column()], 0);
  }
}

/// One pixel that differs in all 16 bits costs 16 / 4 in the 9 windows that hold it, and that in the five columns that are summed for the
/// sub-pixel part: the arithmetic of the costs, without paths.
TEST(SemiGlobal, costs_are_bits_over_three_by_three_pixels) {
  Scene scene(60, 20);
  fill(scene.left, Content::black, 0);
  for (auto& codes : scene.codes) fill(codes, Content::black, 0);
  scene.codes[0].at(30, 10) = scene.codes[1].at(30, 10) = 255;
  SemiGlobal s = scene.search(16, 0, 3);
  s.small = s.large = s.large_least = 0;
  const auto rows = match(kernels("plain"), s);
  const int columns = s.columns(), at = columns + 30 - s.first_column();  // of the costs
  EXPECT_EQ(rows[10][at], 16 / 4) << "of the five columns it is summed over, one lies beside the pixel";
  EXPECT_EQ(rows[11][at - 1], 16 / 4) << "a neighbour's window holds it";
  EXPECT_EQ(rows[12][at], 0);
  EXPECT_EQ(rows[10][at + 6], 16 / 4) << "the fifth column";
  EXPECT_EQ(rows[10][at + 8], 0);
}

}  // namespace
}  // namespace vdisp::kernels
