// speckle_test.cpp: the speckle filter refuses the pixels that cv::filterSpeckles refuses: at every level, for any cut into bands.
// SPDX-License-Identifier: Apache-2.0
#include <functional>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <thread>

#include "tests/kernels/check.h"

namespace vdisp::kernels {
namespace {

constexpr int16_t least = -32000, refused = -32004;
constexpr int none = -32001;

using Pattern = std::function<int(int x, int y)>;

bool on_spiral(int x, int y, int width, int height) {
  const int ring = std::min(std::min(x, y), std::min(width - 1 - x, height - 1 - y));
  // Rings with a gap each are one arm where every second ring has its gap moved into the next.
  return ring % 2 == 0 ? !(x == ring && y == ring + 1) : x == ring && y == ring + 1;
}

/// Pictures of disparities that hurt: by name, for a picture of the size.
std::vector<std::pair<std::string, Pattern>> patterns(int width, int height) {
  const auto noise = [](int x, int y) {
    uint32_t h = static_cast<uint32_t>(x) * 2654435761u ^ static_cast<uint32_t>(y) * 2246822519u;
    h = (h ^ h >> 15) * 2246822519u;
    return static_cast<int>(h >> 8 & 0xFFFF);
  };
  return {
      {"all rejected", [](int x, int y) { return none - (x + y) % 7; }},
      {"one region", [](int, int) { return 300; }},
      {"every pixel a region", [](int x, int y) { return (x + y) % 2 ? 0 : 5000; }},
      {"valid and rejected by turns", [](int x, int y) { return (x + y) % 2 ? 20 : none; }},
      {"just joined", [](int x, int y) { return 16 * x - 16 * y; }},
      {"just not joined", [](int x, int y) { return 17 * x + 17 * y; }},
      {"rows", [](int, int y) { return y % 2 ? 100 : none; }},
      {"columns", [](int x, int) { return x % 2 ? 100 : none; }},
      {"U shapes: joined in the last row", [=](int x, int y) { return x % 2 == 0 || y == height - 1 ? 64 : none; }},
      {"U shapes: joined in every tenth row", [](int x, int y) { return x % 2 == 0 || y % 10 == 9 ? 64 + x / 12 : none; }},
      {"comb with a back on top", [](int x, int y) { return x % 2 == 0 || y == 0 ? 64 : -100; }},
      {"nested Us", [=](int x, int y) { return std::max(std::abs(2 * x - width), 2 * y) % 4 < 2 ? 64 : none; }},
      {"nested caps", [=](int x, int y) { return std::max(std::abs(2 * x - width), 2 * (height - y)) % 4 < 2 ? 64 : 900; }},
      {"spiral", [=](int x, int y) { return on_spiral(x, y, width, height) ? 64 : none; }},
      {"extremes", [=](int x, int y) { return noise(x, y) % 3 == 0   ? 32767
                                              : noise(x, y) % 3 == 1 ? -32000
                                                                     : none; }},
      {"any number", [=](int x, int y) { return noise(x, y) - 32768; }},
      {"noise, half rejected", [=](int x, int y) { return noise(x, y) & 1 ? noise(x, y) % 64 : none; }},
      {"noise, few rejected", [=](int x, int y) { return noise(x, y) % 10 ? noise(x, y) % 40 : none; }},
      {"noise over a slope", [=](int x, int y) { return noise(x, y) % 3 ? x / 2 + y + noise(x, y) % 30 : none - noise(x, y) % 5; }},
      {"blocks", [=](int x, int y) { return noise(x / 9, y / 7) % 4 ? noise(x / 9, y / 7) % 100 : none; }},
  };
}

Picture<int16_t> picture(int width, int height, const Pattern& pattern) {
  Picture<int16_t> made(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) made.at(x, y) = static_cast<int16_t>(pattern(x, y));
  return made;
}

Picture<int16_t> by_opencv(const Picture<int16_t>& in, const SpeckleRule& rule) {
  Picture<int16_t> out = in;
  const Plane<int16_t> p = out.plane();
  cv::Mat image(p.height, p.width, CV_16S), work;
  for (int y = 0; y < p.height; ++y)
    for (int x = 0; x < p.width; ++x) image.at<int16_t>(y, x) = std::max<int16_t>(p.row(y)[x], none);
  cv::filterSpeckles(image, none, rule.max_size, rule.max_difference, work);
  for (int y = 0; y < p.height; ++y)
    for (int x = 0; x < p.width; ++x)
      if (p.row(y)[x] >= rule.least && image.at<int16_t>(y, x) == none) p.row(y)[x] = rule.refused;
  return out;
}

/// `cuts`: the bands' first rows but 0, rising.
void filter(const Kernels& k, const SpeckleRule& rule, const std::vector<int>& cuts, SpeckleScratch& scratch, Plane<int16_t> p) {
  std::vector<int> borders{0};
  borders.insert(borders.end(), cuts.begin(), cuts.end());
  borders.push_back(p.height);
  for (size_t i = borders.size() - 1; i-- > 0;) k.speckle_label(p, rule, borders[i], borders[i + 1], scratch);
  k.speckle_join(p, rule, scratch);
  for (size_t i = 0; i + 1 < borders.size(); ++i) k.speckle_refuse(rule, borders[i], borders[i + 1], scratch, p);
}

void expect_as_opencv(const Kernels& k, int width, int height, SpeckleScratch& scratch, std::vector<std::vector<int>> all_cuts) {
  for (const auto& [name, pattern] : patterns(width, height)) {
    const Picture<int16_t> in = picture(width, height, pattern);
    for (const auto& [max_size, max_difference] : {std::pair{0, 16}, {1, 16}, {2, 0}, {7, 768}, {100, 16}, {width * height, 4}}) {
      const SpeckleRule rule{least, refused, max_difference, max_size};
      const Picture<int16_t> expected = by_opencv(in, rule);
      for (const std::vector<int>& cuts : all_cuts) {
        Picture<int16_t> got = in;
        filter(k, rule, cuts, scratch, got.plane());
        ASSERT_EQ(expected, got) << name << " " << width << "x" << height << " size " << max_size << " difference " << max_difference
                                 << " in " << cuts.size() + 1 << " bands";
      }
    }
  }
}

std::vector<std::vector<int>> cuts_of(int height) {
  std::vector<std::vector<int>> cuts{{}};
  if (height > 1) cuts.push_back({height / 2});
  if (height > 3) cuts.push_back({1, height / 3, height - 1});
  cuts.emplace_back();
  for (int y = 1; y < height; ++y) cuts.back().push_back(y);
  return cuts;
}

void check_sizes(const Kernels& k, const std::vector<std::pair<int, int>>& sizes) {
  for (const auto& [width, height] : sizes) {
    SpeckleScratch scratch(width, height);
    expect_as_opencv(k, width, height, scratch, cuts_of(height));
  }
}

const std::vector<std::pair<int, int>> larger = {{63, 40}, {128, 70}, {130, 33}, {200, 90}, {321, 50}};

TEST(Speckle, plain_refuses_what_opencv_refuses) {
  check_sizes(kernels("plain"), awkward_sizes);
  check_sizes(kernels("plain"), larger);
}

TEST(Speckle, every_level_refuses_what_opencv_refuses) {
  at_each_level([](const std::string&, const Kernels& k) {
    check_sizes(k, awkward_sizes);
    check_sizes(k, larger);
  });
}

TEST(Speckle, the_scratch_of_a_large_image_serves_small_ones_after_it) {
  SpeckleScratch scratch(300, 40);
  for (const std::string& level : levels()) {
    for (const auto& [width, height] : {std::pair{300, 40}, {64, 40}, {299, 3}, {1, 1}}) {
      expect_as_opencv(kernels(level), width, height, scratch, cuts_of(height));
    }
  }
}

TEST(Speckle, nothing_overflows_at_1920x1200) {
  constexpr int width = 1920, height = 1200;
  SpeckleScratch scratch(width, height);
  const SpeckleRule rule{least, refused, 16, 100};
  for (const auto& [name, pattern] : patterns(width, height)) {
    const Picture<int16_t> in = picture(width, height, pattern);
    const Picture<int16_t> expected = by_opencv(in, rule);
    for (const auto& [level, cuts] : {std::pair{"plain", std::vector<int>{}}, {"auto", {300, 301, 900}}}) {
      Picture<int16_t> got = in;
      filter(kernels(level), rule, cuts, scratch, got.plane());
      ASSERT_EQ(expected, got) << name << " " << level;
    }
  }
}

TEST(Speckle, bands_may_run_on_threads_of_their_own) {
  constexpr int width = 200, height = 120, bands = 4;
  const Pattern slope = patterns(width, height)[18].second;
  const Picture<int16_t> in = picture(width, height, slope);
  const SpeckleRule rule{least, refused, 16, 30};
  const Picture<int16_t> expected = by_opencv(in, rule);
  SpeckleScratch scratch(width, height);
  for (const std::string& level : levels()) {
    const Kernels k = kernels(level);
    Picture<int16_t> got = in;
    const Plane<int16_t> p = got.plane();
    const auto on_each_band = [&](auto step) {
      std::vector<std::thread> threads;
      for (int i = 0; i < bands; ++i) threads.emplace_back([=] { step(height * i / bands, height * (i + 1) / bands); });
      for (std::thread& thread : threads) thread.join();
    };
    on_each_band([&](int first, int last) { k.speckle_label(p, rule, first, last, scratch); });
    k.speckle_join(p, rule, scratch);
    on_each_band([&](int first, int last) { k.speckle_refuse(rule, first, last, scratch, p); });
    EXPECT_EQ(expected, got) << level;
  }
}

}  // namespace
}  // namespace vdisp::kernels
