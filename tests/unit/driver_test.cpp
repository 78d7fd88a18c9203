// driver_test.cpp: order, demand, blindness and publication of the tree.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/core/driver.h"

#include <gtest/gtest.h>

#include <chrono>
#include <map>
#include <sstream>
#include <thread>

namespace vdisp {
namespace {

constexpr ImageSpec spec{Pixel::gray8, 0, 8, 4};

struct Source final : ImageSource {
  int frames = 0, last = 1000, bad = -1;
  std::vector<ImageSpec> open() override { return {spec}; }
  Outcome grab(std::span<Image* const> out) noexcept override {
    if (frames == last) return Outcome::end;
    out[0]->timestamp_ns = 1000 + frames;
    out[0]->flags = flag_synthetic;
    *out[0]->row<uint8_t>(0) = static_cast<uint8_t>(frames);
    if (frames++ == bad) {
      out[0]->reason = Reason::bad_pair;
      return Outcome::invalid;
    }
    return Outcome::valid;
  }
};

struct AddOne final : ImageFilter {
  int* runs;
  explicit AddOne(int* counter) : runs(counter) {}
  ImageSpec accept(const ImageSpec& in) override {
    require(in, Pixel::gray8, "the input");
    return in;
  }
  bool filter(const Image& in, Image& out) noexcept override {
    ++*runs;
    *out.row<uint8_t>(0) = static_cast<uint8_t>(*in.row<uint8_t>(0) + 1);
    return true;
  }
};

struct ToRecord final : ImageFilter {
  ImageSpec accept(const ImageSpec&) override { return record_spec<FloorModel>(); }
  bool filter(const Image&, Image&) noexcept override { return true; }
};

struct DriverTest : testing::Test {
  Driver driver{77};
  int near_runs = 0, far_runs = 0;
  std::map<std::string, BufferOutlet*> outlets;
  std::vector<std::string> published;
  Source* source = new Source;
  Handle camera, near, far;

  void build() {
    camera = driver.add("camera", std::unique_ptr<ImageProcessor>(source), {}, Need::always);
    near = driver.add("near", std::make_unique<AddOne>(&near_runs), {camera});
    far = driver.add("far", std::make_unique<AddOne>(&far_runs), {near});
    driver.connect([this](const std::string& topic, const ImageSpec& s) {
      auto outlet = std::make_unique<BufferOutlet>(s);
      outlets[topic] = outlet.get();
      return outlet;
    });
    driver.set_viewer([this](const Topic& topic, const Image&) { published.push_back(topic.name); });
  }
  const Image& image(const std::string& topic) { return outlets.at(topic)->loan(); }
};

TEST_F(DriverTest, nobody_watching_costs_nothing) {
  build();
  EXPECT_EQ(driver.step(), Outcome::valid);
  EXPECT_EQ(near_runs + far_runs, 0);
  EXPECT_EQ(published, std::vector<std::string>{"camera"});
}

TEST_F(DriverTest, a_watched_stage_runs_what_it_needs) {
  build();
  outlets["far"]->watch(true);
  driver.step();
  EXPECT_EQ(near_runs, 1);
  EXPECT_EQ(*image("far").row<uint8_t>(0), 2);
}

TEST_F(DriverTest, an_image_is_published_when_its_last_running_reader_has_run) {
  build();
  outlets["near"]->watch(true);  // far does not run: near must not wait for it
  driver.step();
  EXPECT_EQ(published, (std::vector<std::string>{"camera", "near"}));
  EXPECT_EQ(outlets["near"]->published(), 1u);
}

TEST_F(DriverTest, every_image_carries_the_frame_it_was_made_from) {
  build();
  driver.need_all();
  driver.step();
  driver.step();
  EXPECT_EQ(image("far").sequence, 1u);
  EXPECT_EQ(image("far").epoch, 77u);
  EXPECT_EQ(image("far").timestamp_ns, 1001);
  EXPECT_EQ(image("far").flags, flag_synthetic);
  EXPECT_GE(image("far").ready_ns, image("near").ready_ns);
}

TEST_F(DriverTest, a_bad_pair_makes_all_below_blind_with_the_reason_and_the_run_goes_on) {
  source->bad = 1;
  build();
  driver.need_all();
  EXPECT_EQ(driver.step(), Outcome::valid);
  EXPECT_EQ(driver.step(), Outcome::invalid);
  EXPECT_EQ(image("far").state, ImageState::blind);
  EXPECT_EQ(image("far").reason, Reason::bad_pair);
  EXPECT_EQ(image("far").sequence, 1u);
  EXPECT_EQ(driver.step(), Outcome::valid);
  EXPECT_TRUE(image("far").valid());
  EXPECT_EQ(driver.blind_steps(), 1u);
  EXPECT_EQ(far_runs, 2);
  EXPECT_EQ(driver.timing(far).invalid, 1u);
}

TEST_F(DriverTest, the_source_ends_the_run) {
  source->last = 2;
  build();
  EXPECT_EQ(driver.step(), Outcome::valid);
  EXPECT_EQ(driver.step(), Outcome::valid);
  EXPECT_EQ(driver.step(), Outcome::end);
  EXPECT_EQ(driver.steps(), 2u);
}

TEST_F(DriverTest, a_refused_stage_names_both_ends_and_leaves_no_trace) {
  build();
  const Handle record = driver.add("record", std::make_unique<ToRecord>(), {camera});
  try {
    driver.add("wrong", std::make_unique<AddOne>(&far_runs), {record});
    FAIL() << "a record was accepted as gray8";
  } catch (const FormatError& error) {
    EXPECT_STREQ(error.what(), "stage 'wrong' of 'record' (record 80x1): the input is record, needed is gray8");
  }
  EXPECT_EQ(driver.topics().back().name, "record");
}

TEST_F(DriverTest, a_name_is_given_once) {
  build();
  EXPECT_THROW(driver.add("near", std::make_unique<AddOne>(&far_runs), {camera}), FormatError);
}

TEST_F(DriverTest, the_catalogue_tells_names_parents_and_runs) {
  build();
  driver.need_all();
  driver.step();
  driver.beat();
  const Catalogue* catalogue = record_of<Catalogue>(image("catalogue"));
  ASSERT_NE(catalogue, nullptr);
  ASSERT_EQ(catalogue->count, 3u);
  EXPECT_STREQ(catalogue->entries[2].name, "far");
  EXPECT_EQ(catalogue->entries[2].parents[0], 1);
  EXPECT_EQ(catalogue->entries[2].runs, 1u);
  EXPECT_EQ(outlets["heartbeat"]->published(), 1u);
}

TEST_F(DriverTest, a_pause_does_not_stretch_the_period) {
  // Readers judge by it when an image is stale: the mean of a whole life would let a minute's pause hide a dead camera for long.
  build();
  for (int i = 0; i < 12; ++i) {
    driver.step();
    std::this_thread::sleep_for(std::chrono::milliseconds(i == 4 ? 400 : 5));
  }
  driver.beat();
  EXPECT_LT(record_of<Heartbeat>(image("heartbeat"))->period_ns, 100'000'000);
}

TEST_F(DriverTest, dot_and_profile_name_the_stages) {
  build();
  driver.step();
  std::ostringstream dot, profile;
  driver.write_dot(dot);
  driver.write_profile(profile);
  EXPECT_NE(dot.str().find("\"near\" -> \"far\" [label=\"gray8 8x4\"]"), std::string::npos);
  EXPECT_NE(profile.str().find("far                       disabled"), std::string::npos) << profile.str();
}

}  // namespace
}  // namespace vdisp
