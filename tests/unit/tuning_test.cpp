// tuning_test.cpp: sliders know every live parameter's range by the daemon's words, and each is told with some stage.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <chrono>
#include <cstring>
#include <thread>

#include "config/parameters.h"
#include "probe/view/tuner.h"
#include "tests/support/standin_control.h"
#include "tests/support/temporary_folder.h"

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

/// A daemon that answers when the test lets it, with parameters as they are by default.
struct TunerTalk : testing::Test {
  using Clock = std::chrono::steady_clock;
  TemporaryFolder folder;
  StandInControl daemon{(folder / "control").string()};
  Config config;
  std::vector<std::string> set;  // as they were asked for
  Tuner tuner{(folder / "control").string(), std::chrono::milliseconds(300)};

  /// Answers what has come, until `good`; false: it did not become so.
  template <class Good>
  bool answer_until(const Good& good) {
    for (const auto end = Clock::now() + std::chrono::seconds(5); Clock::now() < end;) {
      for (const auto& heard : daemon.hear()) answer(heard);
      if (const auto line = tuner.hear(); line && !line->empty()) told = *line;
      if (good()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return false;
  }
  void answer(const StandInControl::Heard& heard) {
    ParameterMessage question;
    std::memcpy(&question, heard.bytes.data(), sizeof question);
    const bool by_key = question.key[0] != 0;
    const Parameter& row = by_key ? *find_parameter(question.key) : parameters()[question.index];
    ReplyMessage reply{};
    if (heard.header.type == CommandType::set) {
      set.push_back(row.name() + "=" + question.value + (question.joined ? " joined" : ""));
      reply.answer = refuses ? Answer::refused : Answer::done;
      if (refuses) std::strcpy(reply.text, "not now");
      if (!refuses) row.set(config, question.value);
    }
    const ParameterInfo info = info_of(row, config);
    reply.index = question.index;
    reply.count = static_cast<uint32_t>(parameters().size());
    reply.live = info.live;
    info.key.copy(reply.key, sizeof reply.key - 1);
    info.value.copy(reply.value, sizeof reply.value - 1);
    info.standard.copy(reply.standard, sizeof reply.standard - 1);
    info.allowed.copy(reply.allowed, sizeof reply.allowed - 1);
    daemon.answer(heard, reply);
  }
  void open_disparity() {
    tuner.show("disparity");
    tuner.open(true);
    ASSERT_TRUE(answer_until([&] { return !tuner.panel().sliders.empty(); }));
    for (const Slider& slider : tuner.panel().sliders)
      if (slider.info().key != "image source.thresh") {
        tuner.choose(1);
      } else {
        return;
      }
  }
  std::string value() const { return tuner.panel().sliders[tuner.panel().chosen].info().value; }
  bool refuses = false;
  std::string told;
};

TEST_F(TunerTalk, no_call_waits_for_a_daemon_that_does_not_answer) {
  const auto start = Clock::now();
  tuner.show("disparity");
  tuner.open(true);
  EXPECT_TRUE(tuner.panel().waits);
  tuner.follow(7);
  tuner.undo();
  tuner.save();
  EXPECT_EQ(tuner.hear(), std::nullopt);
  EXPECT_LT(Clock::now() - start, std::chrono::milliseconds(50));
  for (const auto end = start + std::chrono::seconds(3); tuner.panel().trouble.empty() && Clock::now() < end;) {
    tuner.hear();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_NE(tuner.panel().trouble.find("did not answer within 300 ms"), std::string::npos) << tuner.panel().trouble;
}

TEST_F(TunerTalk, what_is_turned_shows_at_once_and_is_what_the_daemon_has_in_the_end) {
  open_disparity();
  EXPECT_EQ(value(), "10");
  tuner.step(1);
  EXPECT_EQ(value(), "11") << "before the daemon has heard of it";
  tuner.follow(1);
  ASSERT_TRUE(answer_until([&] { return config.image_source.thresh == 11; }));
  EXPECT_TRUE(answer_until([&] { return set.size() == 1 && value() == "11"; }));
}

TEST_F(TunerTalk, what_the_daemon_refuses_goes_back_and_is_said) {
  open_disparity();
  refuses = true;
  tuner.step(1);
  EXPECT_EQ(value(), "11");
  ASSERT_TRUE(answer_until([&] { return !tuner.panel().trouble.empty(); }));
  EXPECT_EQ(tuner.panel().trouble, "not now");
  EXPECT_EQ(value(), "10");
}

TEST_F(TunerTalk, of_a_drag_that_is_faster_than_the_daemon_the_newest_place_is_asked_for_as_one_step) {
  open_disparity();
  tuner.press(tuner.panel().chosen, 0.3);
  for (int i = 0; i <= 50; ++i) tuner.drag(0.3 + 0.01 * i);
  EXPECT_EQ(value(), "32");
  tuner.let_go();
  ASSERT_TRUE(answer_until([&] { return config.image_source.thresh == 32; }));
  EXPECT_LE(set.size(), 3u) << "the first, perhaps one more, and the last";
  EXPECT_EQ(set.back(), "image source.thresh=32" + std::string(set.size() > 1 ? " joined" : ""));
}

}  // namespace
}  // namespace vdisp
