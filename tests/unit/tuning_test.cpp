// tuning_test.cpp: sliders know every live parameter's range by the daemon's words, and each is told with some stage.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "config/parameters.h"
#include "probe/view/tuner.h"

namespace vdisp {
namespace {

/// As the control socket tells it.
ParameterInfo info_of(const Parameter& row, const Config& config = {}) {
  return {row.name(),
          row.get(config),
          row.get(Config{}),
          row.allowed(),
          std::string(row.unit),
          std::string(row.help),
          row.when == When::live,
          0,
          0};
}

ParameterInfo info_of(const char* key, const char* value) {
  ParameterInfo info = info_of(*find_parameter(key));
  info.value = value;
  return info;
}

TEST(SliderTest, every_live_parameter_but_a_text_has_a_slider_whose_every_place_can_be_set) {
  int sliders = 0;
  for (const Parameter& row : parameters()) {
    const auto slider = Slider::of(info_of(row));
    const bool text = row.kind == Kind::text || row.kind == Kind::path;
    ASSERT_EQ(slider.has_value(), row.when == When::live && !text) << row.name();
    if (!slider) continue;
    ++sliders;
    for (int i = -2; i <= 102; ++i) {
      Config config;
      const std::string value = slider->at(i / 100.0);
      EXPECT_EQ(row.set(config, value), std::nullopt) << row.name() << " = " << value;
    }
    Config least, most;
    EXPECT_EQ(row.set(least, slider->at(0)), std::nullopt);
    EXPECT_EQ(row.set(most, slider->at(1)), std::nullopt);
    if (row.kind == Kind::whole || row.kind == Kind::real) {
      EXPECT_EQ(std::stod(slider->at(0)), row.least) << row.name();
      EXPECT_EQ(std::stod(slider->at(1)), row.most) << row.name();
    }
    if (row.kind == Kind::whole) {
      EXPECT_TRUE(slider->whole()) << row.name() << ": half a number would be refused";
    }
    Config standard;
    if (const auto place = slider->place()) {
      EXPECT_EQ(row.set(standard, slider->at(*place)), std::nullopt);
      if (row.kind == Kind::whole || row.kind == Kind::choice || row.kind == Kind::flag) {
        EXPECT_EQ(row.get(standard), row.get(Config{})) << "the knob stands where the value is";
      }
    }
  }
  EXPECT_GT(sliders, 25);
}

TEST(SliderTest, steps_up_and_down_reach_both_ends_and_stay_there) {
  for (const Parameter& row : parameters()) {
    auto slider = Slider::of(info_of(row));
    if (!slider) continue;
    for (const int by : {1, -1}) {
      std::string before;
      int steps = 0;
      for (; steps < 1000 && slider->info().value != before; ++steps) {
        before = slider->info().value;
        ParameterInfo next = slider->info();
        next.value = slider->moved(by);
        slider->take(next);
      }
      ASSERT_LT(steps, 1000) << row.name();
      EXPECT_EQ(slider->info().value, slider->at(by > 0 ? 1 : 0)) << row.name();
    }
  }
}

TEST(SliderTest, whole_numbers_go_one_by_one_and_words_in_their_order) {
  EXPECT_EQ(Slider::of(info_of("image source.thresh", "10"))->moved(1), "11");
  EXPECT_EQ(Slider::of(info_of("image source.thresh", "40"))->moved(1), "40");
  EXPECT_EQ(Slider::of(info_of("image source.smooth", "mean"))->moved(1), "median");
  EXPECT_EQ(Slider::of(info_of("image source.smooth", "none"))->moved(-1), "none");
  EXPECT_EQ(Slider::of(info_of("image source.SpeckleSize", "0"))->moved(1), "1");
  EXPECT_EQ(Slider::of(info_of("Limit obstacle.angRot", "auto"))->place(), std::nullopt);
  EXPECT_EQ(Slider::of(info_of("image source.ndisp", "48")), std::nullopt) << "needs a restart";
}

TEST(SliderTest, the_usual_value_of_a_wide_range_is_not_at_its_end) {
  EXPECT_GT(*Slider::of(info_of("image source.SpeckleSize", "100"))->place(), 0.15);  // of 0 to 10000
  EXPECT_NEAR(*Slider::of(info_of("image source.thresh", "10"))->place(), 0.25, 1e-9);
}

TEST(TunerTest, each_live_parameter_is_told_with_some_stage_and_unknown_stages_have_all) {
  for (const Parameter& row : parameters()) {
    if (row.when != When::live) continue;
    bool told = false;
    for (const char* topic :
         {"camera/left", "disparity", "floor_model", "surface", "map", "fused", "in/odometry", "snow", "decision", "recorder"})
      told |= concerns(topic, row.name());
    EXPECT_TRUE(told) << row.name();
    EXPECT_TRUE(concerns("a stage that is new", row.name()));
  }
  EXPECT_TRUE(concerns("disparity", "image source.thresh"));
  EXPECT_FALSE(concerns("disparity", "Map.minCount"));
  EXPECT_TRUE(concerns("fused_reason", "Memory.keep"));
  EXPECT_TRUE(concerns("camera/right", "main.period"));
}

}  // namespace
}  // namespace vdisp
