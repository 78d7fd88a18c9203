// floor_test.cpp: points on a plane, and heights over the floor: the same at every level, and against arithmetic.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>

#include "tests/kernels/check.h"

namespace vdisp::kernels {
namespace {

struct Cloud {
  std::array<std::vector<float>, 3> lists;
  explicit Cloud(size_t n, uint32_t seed) {
    std::minstd_rand random(seed + 1);
    for (auto& list : lists) list.assign(point_room(n), 0.0f);
    for (size_t i = 0; i < n; ++i) {
      lists[0][i] = static_cast<float>(random() % 640) - 320;
      lists[1][i] = static_cast<float>(random() % 480) - 240;
      lists[2][i] = static_cast<float>(random() % 1024) / 16;
    }
  }
  DisparityPoints points() { return {lists[0].data(), lists[1].data(), lists[2].data()}; }
};

TEST(CountOnPlane, is_the_same_at_every_level) {
  at_each_level([](const std::string&, const Kernels& k) {
    for (size_t n : {0, 1, 3, 15, 16, 17, 64, 1000, 5003}) {
      Cloud cloud(n, static_cast<uint32_t>(n));
      for (const DisparityPlane& plane : {DisparityPlane{0, 0.11f, 20}, DisparityPlane{0.02f, 0.3f, -5}, DisparityPlane{0, 0, -1}}) {
        const PlaneReach reach{0.75f, 0.03f};
        ASSERT_EQ(k.count_on_plane(cloud.points(), n, plane, reach), plain::count_on_plane(cloud.points(), n, plane, reach)) << n;
      }
    }
  });
}

TEST(CountOnPlane, counts_what_is_on_it_and_what_is_beyond_and_nothing_above_the_horizon) {
  Cloud cloud(5, 0);
  const float d[] = {10, 10.9f, 11.1f, 7.9f, 30};
  for (size_t i = 0; i < 5; ++i) {
    cloud.lists[0][i] = 0;
    cloud.lists[1][i] = 100;
    cloud.lists[2][i] = d[i];
  }
  const PlaneCount count = plain::count_on_plane(cloud.points(), 5, {0, 0.1f, 0}, {1, 0});
  EXPECT_EQ(count.on, 2u) << "10 and 10.9 are within 1 px of 10";
  EXPECT_EQ(count.beyond, 1u) << "7.9 is farther by more than 2 px; what is nearer stands on the floor";
  EXPECT_EQ(plain::count_on_plane(cloud.points(), 5, {0, -0.1f, 0}, {100, 0}), PlaneCount{}) << "a plane above its horizon is nowhere";
}

TEST(SumOnPlane, is_the_same_at_every_level) {
  at_each_level([](const std::string&, const Kernels& k) {
    for (size_t n : {0, 1, 3, 4, 5, 15, 64, 1000, 5003}) {
      Cloud cloud(n, static_cast<uint32_t>(n));
      for (const PlaneFit& plane :
           {PlaneFit{0, 0.11, 20, 0.75, 0.03, 0.7}, PlaneFit{0.02, 0.3, -5, 1.1, 0.04, 1}, PlaneFit{0, 0, -1, 1, 0, 1}})
        ASSERT_EQ(k.sum_on_plane(cloud.points(), n, plane), plain::sum_on_plane(cloud.points(), n, plane)) << n;
    }
  });
}

/// On a plane of 10 px everywhere: what lies on it counts whole, halfway to the end of its reach 9/16, on the nearer side by half that
/// reach.
TEST(SumOnPlane, weighs_by_what_a_point_is_off) {
  Cloud cloud(5, 0);
  const float d[] = {10, 9.5f, 10.25f, 10.6f, 8.9f};
  for (size_t i = 0; i < 5; ++i) {
    cloud.lists[0][i] = 2;
    cloud.lists[1][i] = 3;
    cloud.lists[2][i] = d[i];
  }
  const PlaneSums sums = plain::sum_on_plane(cloud.points(), 5, {0, 0, 10, 1, 0, 0.5});
  const double weight = 1 + 2 * 9 / 16.0;
  EXPECT_EQ(sums.one, weight);
  EXPECT_EQ(sums.d, 10 + (9.5 + 10.25) * 9 / 16);
  EXPECT_EQ(sums.uv, 6 * weight);
  EXPECT_EQ(sums.uu, 4 * weight);
  EXPECT_EQ(sums.v, 3 * weight);
  EXPECT_EQ(plain::sum_on_plane(cloud.points(), 5, {0, 0, -10, 100, 0, 1}).one, 0) << "a plane above its horizon is nowhere";
}

TEST(SumOnPlane, takes_nothing_from_the_room_behind_the_points) {
  at_each_level([](const std::string& level, const Kernels& k) {
    for (size_t n = 0; n < 20; ++n) {
      Cloud cloud(n, 0);
      for (auto& list : cloud.lists) std::fill(list.begin(), list.end(), 10.0f);  // all of it lies on the plane
      EXPECT_EQ(k.sum_on_plane(cloud.points(), n, {0, 0, 10, 1, 0, 1}).one, static_cast<double>(n)) << level << ", " << n << " points";
    }
  });
}

struct Heights {
  std::vector<int16_t> height, obstacles, overhangs;
  std::vector<uint8_t> surface;
  explicit Heights(size_t n) : height(n + 8, 7), obstacles(n + 8, 7), overhangs(n + 8, 7), surface(n + 8, 7) {}
  HeightOut out() { return {height.data(), surface.data(), obstacles.data(), overhangs.data(), INT16_MIN, -32006}; }
  bool operator==(const Heights&) const = default;
};

TEST(MeasureHeights, is_the_same_at_every_level) {
  const Search search{-32, 16, 16 * 48};
  std::vector<HeightOf> table(static_cast<size_t>(search.columns));
  for (size_t i = 0; i < table.size(); ++i)
    table[i] = {800.0f * 16 / static_cast<float>(static_cast<int>(i) - 31), static_cast<float>(i % 100) - 50};
  at_each_level([&](const std::string&, const Kernels& k) {
    for (int n : {1, 7, 16, 33, 640, 641}) {
      std::minstd_rand random(static_cast<uint32_t>(n));
      std::vector<int16_t> d(static_cast<size_t>(n));
      for (auto& pixel : d) pixel = static_cast<int16_t>(random() % 3 ? random() % 800 : -32001);
      if (n == 640) std::fill(d.begin() + 100, d.begin() + 300, int16_t{-32003});  // whole vectors without a disparity
      Heights expected(d.size()), got(d.size());
      const HeightRow row{800, 12.3f, 0.017f, 200, 900, 150};
      plain::measure_heights(d.data(), n, search, row, table.data(), expected.out());
      k.measure_heights(d.data(), n, search, row, table.data(), got.out());
      ASSERT_EQ(got, expected) << n << " pixels";
    }
  });
}

/// Heights of whole mm, one by one: a profile of 20 px over a floor at 20 px. 32 pixels, so that vectors take them.
TEST(MeasureHeights, limits_belong_to_what_lies_beyond_them_and_heights_end_at_32_m) {
  const Search search{0, 1, 64};
  const int of_pixel[] = {199, 200, 899, 900, -149, -150, 0, 31999, 32000, 40000, -31999, -32000, -40000};
  const Surface expected[] = {Surface::floor, Surface::obstacle, Surface::obstacle, Surface::overhang, Surface::floor,
                              Surface::below, Surface::floor,    Surface::overhang, Surface::overhang, Surface::overhang,
                              Surface::below, Surface::below,    Surface::below};
  std::vector<HeightOf> table(64);
  std::vector<int16_t> d(64);
  for (size_t i = 0; i < 64; ++i) {
    table[i] = {0, -static_cast<float>(of_pixel[i % 13])};
    d[i] = static_cast<int16_t>(i);
  }
  at_each_level([&](const std::string& level, const Kernels& k) {
    Heights h(d.size());
    k.measure_heights(d.data(), 64, search, {0, 20, 0, 200, 900, 150}, table.data(), h.out());
    for (size_t i = 1; i < 64; ++i) {
      EXPECT_EQ(h.height[i], std::clamp(of_pixel[i % 13], -32000, 32000)) << level;
      EXPECT_EQ(h.surface[i], static_cast<uint8_t>(expected[i % 13])) << level << ", " << of_pixel[i % 13] << " mm";
      EXPECT_EQ(h.obstacles[i], expected[i % 13] == Surface::obstacle ? d[i] : -32006) << level;
      EXPECT_EQ(h.overhangs[i], expected[i % 13] == Surface::overhang ? d[i] : -32006) << level;
    }
  });
}

/// A camera 0.8 m high sees the floor with 20 px: what has 40 px there lies halfway to it, and so halfway up.
TEST(MeasureHeights, follow_from_the_proportion_of_disparities) {
  const Search search{0, 16, 16 * 64};
  std::vector<HeightOf> table(1024);
  for (size_t i = 1; i < table.size(); ++i) table[i] = {800.0f * 16 / static_cast<float>(i), i == 16 * 40 ? 100.0f : 0.0f};
  const std::vector<int16_t> d{16 * 20, 16 * 40, 16 * 60, 16 * 16, 0};
  Heights h(d.size());
  plain::measure_heights(d.data(), 5, search, {800, 20, 0, 200, 500, 150}, table.data(), h.out());
  EXPECT_EQ(h.height[0], 0);
  EXPECT_EQ(h.height[1], 300) << "400 mm over the plane, and the local floor 100 mm";
  EXPECT_EQ(h.height[2], 533);
  EXPECT_EQ(h.height[3], -200) << "farther than the floor";
  EXPECT_EQ(h.height[4], INT16_MIN);
  const auto surface = [&](size_t i) { return static_cast<Surface>(h.surface[i]); };
  EXPECT_EQ(surface(0), Surface::floor);
  EXPECT_EQ(surface(1), Surface::obstacle);
  EXPECT_EQ(surface(2), Surface::overhang);
  EXPECT_EQ(surface(3), Surface::below);
  EXPECT_EQ(surface(4), Surface::none);
  EXPECT_EQ(h.obstacles[1], 16 * 40);
  EXPECT_EQ(h.overhangs[2], 16 * 60);
  EXPECT_EQ(h.obstacles[0], -32006);
  EXPECT_EQ(h.height[5], 7) << "nothing is written behind the row";
}

}  // namespace
}  // namespace vdisp::kernels
