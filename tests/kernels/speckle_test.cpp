// speckle_test.cpp: the speckle filter refuses the same pixels at every level, for any cut into bands.
// SPDX-License-Identifier: Apache-2.0
#include <thread>

#include "tests/kernels/speckle_pictures.h"

namespace vdisp::kernels {
namespace {

/// By the plain form, in one band.
Picture<int16_t> by_plain(const Picture<int16_t>& in, const SpeckleRule& rule) {
  Picture<int16_t> out = in;
  SpeckleScratch scratch(in.view().width, in.view().height);
  filter(kernels("plain"), rule, {}, scratch, out.plane());
  return out;
}

void expect_as_plain(const Kernels& k, int width, int height, SpeckleScratch& scratch) {
  for (const auto& [name, pattern] : patterns(width, height)) {
    const Picture<int16_t> in = picture(width, height, pattern);
    for (const auto& [max_size, max_difference] : rules_for(width * height)) {
      const SpeckleRule rule{least, refused, max_difference, max_size};
      const Picture<int16_t> expected = by_plain(in, rule);
      for (const std::vector<int>& cuts : cuts_of(height)) {
        Picture<int16_t> got = in;
        filter(k, rule, cuts, scratch, got.plane());
        ASSERT_EQ(expected, got) << name << " " << width << "x" << height << " size " << max_size << " difference " << max_difference
                                 << " in " << cuts.size() + 1 << " bands";
      }
    }
  }
}

void check_sizes(const Kernels& k) {
  for (const auto& sizes : {awkward_sizes, larger_sizes}) {
    for (const auto& [width, height] : sizes) {
      SpeckleScratch scratch(width, height);
      expect_as_plain(k, width, height, scratch);
    }
  }
}

TEST(Speckle, every_level_refuses_what_the_plain_form_refuses_in_any_bands) {
  for (const std::string& level : levels()) {
    SCOPED_TRACE(level);
    check_sizes(kernels(level));
  }
}

/// By hand: an area of `max_size` pixels goes, one of a pixel more stays; a step of `max_difference` joins, one more does not.
TEST(Speckle, an_area_is_refused_up_to_the_size_and_joined_up_to_the_difference) {
  for (const std::string& level : levels()) {
    const auto kept = [&](int pixels, int step) {
      Picture<int16_t> image(12, 3);
      for (int y = 0; y < 3; ++y)
        for (int x = 0; x < 12; ++x) image.at(x, y) = static_cast<int16_t>(y == 1 && x < pixels ? 100 + step * x : none);
      SpeckleScratch scratch(12, 3);
      filter(kernels(level), {least, refused, 4, 5}, {1, 2}, scratch, image.plane());
      int count = 0;
      for (int x = 0; x < pixels; ++x) count += image.at(x, 1) != refused;
      return count;
    };
    EXPECT_EQ(kept(5, 0), 0) << level;
    EXPECT_EQ(kept(6, 0), 6) << level;
    EXPECT_EQ(kept(10, 4), 10) << level;
    EXPECT_EQ(kept(10, 5), 0) << level;
  }
}

TEST(Speckle, the_scratch_of_a_large_image_serves_small_ones_after_it) {
  SpeckleScratch scratch(300, 40);
  for (const std::string& level : levels()) {
    for (const auto& [width, height] : {std::pair{300, 40}, {64, 40}, {299, 3}, {1, 1}}) {
      expect_as_plain(kernels(level), width, height, scratch);
    }
  }
}

TEST(Speckle, bands_may_run_on_threads_of_their_own) {
  constexpr int width = 200, height = 120, bands = 4;
  const Pattern slope = patterns(width, height)[18].second;
  const Picture<int16_t> in = picture(width, height, slope);
  const SpeckleRule rule{least, refused, 16, 30};
  const Picture<int16_t> expected = by_plain(in, rule);
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
