// snow_test.cpp: features, Winnow, ROC, each against what arithmetic by hand says.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "daemon/snow/encoding.h"
#include "daemon/snow/network.h"
#include "daemon/snow/roc.h"
#include "tests/support/picture.h"

namespace vdisp::snow {
namespace {

TEST(Features, figure_9_gives_the_papers_numbers) {
  EXPECT_EQ(feature_id(79, 59, 49), 1309489u);
  EXPECT_EQ(feature_id(0, 0, 68), 68u);
  EXPECT_EQ(vector_length, 2097152u);
  EXPECT_EQ(feature_id(79, 59, 255), 1309695u);
}

TEST(Features, no_encoding_makes_an_id_above_1309695_or_the_same_twice) {
  for (const Encoding encoding : encodings) {
    Picture picture(feature_spec(encoding));
    // The greatest that make_features writes: 255 in the maps, row 59 and height 16 in the contours.
    const bool map = active_features(encoding) == 4800;
    picture.fill<uint8_t>([map](int row, int) { return static_cast<uint8_t>(map ? 255 : row == 0 ? rows - 1 : height_levels); });
    std::vector<uint32_t> ids(active_features(encoding));
    feature_ids(encoding, picture.image(), ids);
    EXPECT_LE(*std::max_element(ids.begin(), ids.end()), 1309695u) << name(encoding);
    EXPECT_EQ(std::set<uint32_t>(ids.begin(), ids.end()).size(), ids.size()) << name(encoding);
  }
}

// Whatever the matcher says: nothing, the nearest and beyond, everywhere, in views of all sizes.
TEST(Features, no_disparities_make_an_id_above_1309695) {
  for (const auto& [width, height] : {std::pair{80, 60}, {320, 240}, {333, 250}, {1920, 1440}}) {
    for (const int disparities : {16, 32, 256}) {
      for (const int16_t pixel :
           {rejected(Rejected::low_texture), int16_t{0}, int16_t{1}, static_cast<int16_t>(16 * disparities - 1), int16_t{INT16_MAX}}) {
        Picture disparity(Pixel::disparity16, width, height), depths(Pixel::count16, width, disparities);
        disparity.fill<int16_t>([pixel = pixel](int, int) { return pixel; });
        depths.fill<int16_t>([](int, int) { return int16_t{INT16_MAX}; });  // more than any view has
        for (const Encoding encoding : encodings) {
          Picture features(feature_spec(encoding));
          make_features(encoding, disparity.image(), depths.image(), disparities, features.image());
          std::vector<uint32_t> ids(active_features(encoding));
          feature_ids(encoding, features.image(), ids);
          ASSERT_LE(*std::max_element(ids.begin(), ids.end()), 1309695u)
              << name(encoding) << " " << width << " " << disparities << " " << pixel;
        }
      }
    }
  }
}

TEST(Features, ids_of_a_map_are_those_of_its_pixels) {
  Picture picture(feature_spec(Encoding::depth_map));
  picture.at<uint8_t>(59, 79) = 49;
  picture.at<uint8_t>(0, 0) = 68;
  std::vector<uint32_t> ids(4800);
  feature_ids(Encoding::depth_map, picture.image(), ids);
  EXPECT_EQ(ids[0], 68u);
  EXPECT_EQ(ids[4799], 1309489u);
  EXPECT_EQ(ids[1], 1u << 14);
}

TEST(Features, names_are_read_back) {
  for (const Encoding encoding : encodings) EXPECT_EQ(encoding_named(name(encoding)), encoding);
  EXPECT_EQ(encoding_named("depthmap"), std::nullopt);
}

/// 320x240 with a wall of disparity d in columns [first, last), as high as `high` px from the top.
struct Wall {
  Wall(int disparities, int first, int last, int d, int high)
      : disparity(Pixel::disparity16, 320, 240), depths(Pixel::count16, 320, disparities) {
    disparity.fill<int16_t>(
        [=](int v, int u) { return u >= first && u < last && v < high ? static_cast<int16_t>(16 * d) : rejected(Rejected::low_texture); });
    for (int u = first; u < last; ++u) depths.at<int16_t>(d, u) = static_cast<int16_t>(high);
  }
  Picture features(Encoding encoding) {
    Picture picture(feature_spec(encoding));
    make_features(encoding, disparity.image(), depths.image(), depths.spec().height, picture.image());
    return picture;
  }
  Picture disparity, depths;
};

TEST(Features, depth_map_sums_four_columns_in_the_row_of_the_disparity) {
  Wall wall(32, 40, 46, 20, 10);
  Picture found = wall.features(Encoding::depth_map);
  EXPECT_EQ(found.at<uint8_t>(37, 10), 40);  // floor(60 * 20 / 32) = 37; columns 40 to 43
  EXPECT_EQ(found.at<uint8_t>(37, 11), 20);  // columns 44 and 45
  EXPECT_EQ(found.at<uint8_t>(37, 12), 0);
  EXPECT_EQ(found.at<uint8_t>(36, 10), 0);
}

TEST(Features, depth_map_is_clipped_at_255) {
  Wall wall(32, 0, 4, 31, 240);
  EXPECT_EQ(wall.features(Encoding::depth_map).at<uint8_t>(58, 0), 255);  // 960; floor(60 * 31 / 32) = 58
}

TEST(Features, depth_map_adds_disparities_that_share_a_row) {
  Wall wall(128, 0, 4, 90, 10);
  for (int u = 0; u < 4; ++u) wall.depths.at<int16_t>(91, u) = 3;
  EXPECT_EQ(wall.features(Encoding::depth_map).at<uint8_t>(42, 0), 52);  // 60 * 90 / 128 = 42.2, 60 * 91 / 128 = 42.7
}

TEST(Features, what_has_no_disparity_is_not_in_the_depth_map) {
  Wall wall(32, 0, 320, 0, 240);
  Picture found = wall.features(Encoding::depth_map);
  for (int x = 0; x < columns; ++x) EXPECT_EQ(found.at<uint8_t>(0, x), 0);
}

TEST(Features, disparity_map_is_the_mean_of_what_is_there) {
  Wall wall(64, 0, 4, 20, 4);
  wall.disparity.at<int16_t>(0, 0) = 16 * 4;                               // (15 * 20 + 4) / 16 = 19
  for (int u = 4; u < 8; ++u) wall.disparity.at<int16_t>(0, u) = 16 * 50;  // 4 of 16: too few
  Picture found = wall.features(Encoding::disparity_map);
  EXPECT_EQ(found.at<uint8_t>(0, 0), 19);
  EXPECT_EQ(found.at<uint8_t>(0, 1), 0);
  EXPECT_EQ(found.at<uint8_t>(1, 0), 0);
}

TEST(Features, contour_is_the_row_of_the_nearest_that_stands) {
  Wall wall(32, 100, 140, 16, 120);
  for (int u = 100; u < 140; ++u) wall.depths.at<int16_t>(30, u) = 8;  // floor: 8 rows of 240 are less than a sixteenth
  Picture found = wall.features(Encoding::contour);
  EXPECT_EQ(found.at<uint8_t>(0, 25), 30);  // 60 * 16 / 32
  EXPECT_EQ(found.at<uint8_t>(0, 34), 30);
  EXPECT_EQ(found.at<uint8_t>(0, 35), 0);
}

TEST(Features, contour_with_height_tells_how_much_of_the_column_it_fills) {
  Wall wall(32, 0, 4, 16, 120);
  Picture found = wall.features(Encoding::contour_height);
  EXPECT_EQ(found.at<uint8_t>(0, 0), 30);
  EXPECT_EQ(found.at<uint8_t>(1, 0), 8);  // half of 16
  std::vector<uint32_t> ids(80);
  feature_ids(Encoding::contour_height, found.image(), ids);
  EXPECT_EQ(ids[0], feature_id(0, 30, 8));
  EXPECT_EQ(ids[1], feature_id(1, 0, 0));
}

constexpr uint32_t both[] = {7, 1309695};
constexpr uint32_t other[] = {7, 9};

TEST(WinnowTarget, initial_weight_is_the_threshold_over_the_mean_number_of_features) {
  Winnow winnow;
  winnow.theta = 4;
  EXPECT_DOUBLE_EQ(initial_weight(winnow, 4800), 4.0 / 4800);
  winnow.initial = 0.2;
  EXPECT_DOUBLE_EQ(initial_weight(winnow, 4800), 0.2);
}

TEST(WinnowTarget, promotes_and_demotes_as_by_hand) {
  Winnow winnow;
  winnow.theta = 4, winnow.alpha = 1.5, winnow.beta = 0.5, winnow.initial = 1;
  Target target(winnow, 2);
  EXPECT_TRUE(target.learn(both, true));  // 2 <= 4: weights 1.5, 1.5
  EXPECT_DOUBLE_EQ(target.activation(both), 3);
  EXPECT_TRUE(target.learn(both, true));   // 3 <= 4: 2.25, 2.25
  EXPECT_FALSE(target.learn(both, true));  // 4.5 > 4: right
  EXPECT_DOUBLE_EQ(target.activation(both), 4.5);
  EXPECT_FALSE(target.learn(other, false));  // 2.25 + 1 = 3.25 < 4: right, and 9 has a link now
  EXPECT_DOUBLE_EQ(target.weights()[9], 1);
  EXPECT_TRUE(target.learn(both, false));  // 4.5 >= 4: 1.125, 1.125
  EXPECT_DOUBLE_EQ(target.weights()[7], 1.125);
  EXPECT_DOUBLE_EQ(target.weights()[9], 1);
  EXPECT_EQ(target.weights()[8], 0);  // never seen: no link
}

TEST(WinnowTarget, an_activation_that_equals_the_threshold_is_a_mistake_of_both_kinds) {
  Winnow winnow;
  winnow.theta = 4, winnow.alpha = 2, winnow.beta = 0.5, winnow.initial = 2;
  Target target(winnow, 2);
  EXPECT_TRUE(target.learn(both, true));
  EXPECT_DOUBLE_EQ(target.activation(both), 8);
  EXPECT_TRUE(target.learn(both, false));
  EXPECT_DOUBLE_EQ(target.activation(both), 4);
  EXPECT_TRUE(target.learn(both, false));
  EXPECT_DOUBLE_EQ(target.activation(both), 2);
}

TEST(WinnowTarget, thick_separator_promotes_and_demotes_inside_it) {
  Winnow winnow;
  winnow.theta = 4, winnow.alpha = 2, winnow.beta = 0.5, winnow.initial = 2.25, winnow.above = 0.25, winnow.below = 0.25;
  EXPECT_TRUE(Target(winnow, 2).learn(both, true));  // 4.5 <= 5
  winnow.initial = 1.75;
  EXPECT_TRUE(Target(winnow, 2).learn(both, false));  // 3.5 >= 3
  winnow.above = winnow.below = 0;
  EXPECT_FALSE(Target(winnow, 2).learn(both, false));  // 3.5 < 4
  winnow.initial = 2.25;
  EXPECT_FALSE(Target(winnow, 2).learn(both, true));  // 4.5 > 4
}

/// Class 1 has feature 2 i + 1 where class 2 has 2 i, among features that tell nothing.
Examples separable(size_t count) {
  Examples examples;
  examples.count = count;
  examples.most_active = 30;
  examples.features = [](size_t example, std::span<uint32_t> ids) -> std::span<const uint32_t> {
    for (uint32_t i = 0; i < 30; ++i) ids[i] = 1000 * i + static_cast<uint32_t>(example * (i + 3) % 17);
    ids[5] = 50000 + 2 * (static_cast<uint32_t>(example) % 3) + static_cast<uint32_t>(example % 2);
    return ids;
  };
  examples.first_class = [](size_t example) { return example % 2 == 1; };
  return examples;
}

TEST(WinnowTraining, learns_what_can_be_separated_and_ends_there) {
  Winnow winnow;
  winnow.alpha = 1.3, winnow.beta = 0.7, winnow.passes = 200;
  const Examples examples = separable(300);
  uint32_t passes = 0;
  size_t last = 1;
  const auto count = [&](uint32_t, size_t mistakes) { return ++passes, last = mistakes, true; };
  const Target first = train_target(winnow, examples, true, count), second = train_target(winnow, examples, false);
  EXPECT_EQ(last, 0u);
  EXPECT_LT(passes, 200u);
  std::vector<uint32_t> ids(30);
  for (size_t i = 0; i < examples.count; ++i) {
    const auto features = examples.features(i, ids);
    EXPECT_EQ(first.activation(features) > second.activation(features), examples.first_class(i)) << i;
  }
}

TEST(WinnowTraining, gives_the_same_weights_each_time_and_others_for_another_order) {
  Winnow winnow;
  winnow.passes = 3;
  const Examples examples = separable(100);
  const auto weights = [&] {
    const Target target = train_target(winnow, examples, true);
    return std::vector<float>(target.weights().begin(), target.weights().end());
  };
  const auto once = weights();
  EXPECT_EQ(once, weights());
  winnow.seed = 2;
  EXPECT_NE(once, weights());
}

TEST(WinnowTraining, an_example_of_weight_two_is_seen_twice) {
  Winnow winnow;
  winnow.theta = 100, winnow.alpha = 2, winnow.initial = 1, winnow.passes = 1;
  Examples examples = separable(2);
  examples.weight = [](size_t example) { return example == 1 ? 2u : 0u; };
  const Target target = train_target(winnow, examples, true);  // 30 <= 100, 60 <= 100: promoted twice
  EXPECT_DOUBLE_EQ(target.weights()[50003], 4);
}

TEST(Roc, area_counts_pairs_in_order_and_half_of_the_ties) {
  // Positives 3, 2, 1; negatives 2, 0: of six pairs 3>2, 3>0, 2>0, 1>0 are right, 2=2 half, 1<2 wrong.
  const std::vector<Judged> judged{{3, true}, {2, true}, {1, true}, {2, false}, {0, false}};
  EXPECT_DOUBLE_EQ(area_under_curve(judged), 4.5 / 6);
}

TEST(Roc, area_is_one_half_without_knowledge_and_one_with_all) {
  EXPECT_DOUBLE_EQ(area_under_curve(std::vector<Judged>{{1, true}, {1, false}, {1, false}}), 0.5);
  EXPECT_DOUBLE_EQ(area_under_curve(std::vector<Judged>{{2, true}, {1, false}}), 1);
  EXPECT_DOUBLE_EQ(area_under_curve(std::vector<Judged>{{1, true}, {2, false}}), 0);
  EXPECT_TRUE(std::isnan(area_under_curve(std::vector<Judged>{{1, true}})));
}

TEST(Roc, area_of_ranks_is_that_under_the_curve_by_trapezoids) {
  std::vector<Judged> judged;
  for (uint32_t i = 0; i < 500; ++i) judged.push_back({static_cast<double>((i * 7919) % 41 + (i % 3 == 0 ? 9 : 0)), i % 3 == 0});
  const auto curve = roc_curve(judged);
  double area = 0;
  for (size_t i = 1; i < curve.size(); ++i)
    area += (curve[i].false_rate - curve[i - 1].false_rate) * (curve[i].true_rate + curve[i - 1].true_rate) / 2;
  EXPECT_NEAR(area_under_curve(judged), area, 1e-12);
  EXPECT_DOUBLE_EQ(curve.back().false_rate, 1);
  EXPECT_DOUBLE_EQ(curve.back().true_rate, 1);
}

TEST(Roc, a_point_of_the_curve_is_what_its_threshold_gives) {
  const std::vector<Judged> judged{{3, true}, {2, true}, {1, true}, {2, false}, {0, false}};
  const auto curve = roc_curve(judged);
  ASSERT_EQ(curve.size(), 5u);  // infinity, 3, 2, 1, 0
  const RocPoint point = point_of_detection(curve, 0.5);
  EXPECT_DOUBLE_EQ(point.threshold, 2);
  EXPECT_DOUBLE_EQ(point.true_rate, 2.0 / 3);
  EXPECT_DOUBLE_EQ(point.false_rate, 0.5);
  const Confusion found = confusion(judged, point.threshold);
  EXPECT_EQ(found.hits, 2u);
  EXPECT_EQ(found.misses, 1u);
  EXPECT_EQ(found.false_alarms, 1u);
  EXPECT_EQ(found.rejections, 1u);
  EXPECT_DOUBLE_EQ(found.accuracy(), 0.6);
  EXPECT_DOUBLE_EQ(best_point(curve).threshold, 1);  // 1 - 0.5 is the most, as 1/3 - 0 and 2/3 - 1/2 are less
}

TEST(Roc, no_chosen_point_has_the_infinite_threshold) {
  const auto curve = roc_curve(std::vector<Judged>{{1, true}, {2, false}, {3, false}});  // worse than chance
  EXPECT_DOUBLE_EQ(point_of_detection(curve, 0).threshold, 3);
  EXPECT_TRUE(std::isfinite(best_point(curve).threshold));
}

}  // namespace
}  // namespace vdisp::snow
