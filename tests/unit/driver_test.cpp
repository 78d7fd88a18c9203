// driver_test.cpp: order, demand, blindness and publication of the tree.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/core/driver.h"

#include <gtest/gtest.h>

#include <chrono>
#include <map>
#include <sstream>
#include <thread>

#include "tests/support/count_allocations.h"

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
    connect();
  }
  void connect() {
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

/// Two inputs; the second one's state becomes a pixel.
struct AsksState final : ImageProcessor {
  std::vector<ImageSpec> check(std::span<const ImageSpec> in) override { return {in[0]}; }
  Outcome process(std::span<const Image* const> in, std::span<Image* const> out) noexcept override {
    *out[0]->row<uint8_t>(0) = in[1]->valid() ? 1 : 2;
    return Outcome::valid;
  }
};

/// Valid, but for one frame, in which it is blind itself.
struct OnceBlind final : ImageFilter {
  uint64_t frame;
  explicit OnceBlind(uint64_t when) : frame(when) {}
  ImageSpec accept(const ImageSpec& in) override { return in; }
  bool filter(const Image& in, Image& out) noexcept override {
    out.reason = Reason::no_odometry;
    return in.sequence != frame;
  }
};

TEST_F(DriverTest, an_input_that_may_be_blind_does_not_make_its_reader_blind_others_do) {
  source->bad = 2;
  camera = driver.add("camera", std::unique_ptr<ImageProcessor>(source), {}, Need::always);
  const Handle maybe = driver.add("maybe", std::make_unique<OnceBlind>(1), {camera});
  driver.add("asks", std::make_unique<AsksState>(), {camera, even_blind(maybe)});
  driver.add("needs", std::make_unique<AsksState>(), {camera, maybe});
  connect();
  driver.need_all();
  driver.step();
  EXPECT_EQ(*image("asks").row<uint8_t>(0), 1);
  driver.step();
  EXPECT_TRUE(image("asks").valid());
  EXPECT_EQ(*image("asks").row<uint8_t>(0), 2);
  EXPECT_EQ(image("needs").reason, Reason::no_odometry);
  driver.step();
  EXPECT_EQ(image("asks").reason, Reason::bad_pair) << "its other input is blind";
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
    EXPECT_STREQ(error.what(), "stage 'wrong' of 'record' (record 416x1): the input is record, needed is gray8");
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

/// A stage that looks back: what it saw of the last frame.
struct LookBack final : ImageProcessor {
  struct Seen {
    bool valid;
    Reason reason;
    uint64_t age;
    int pixel;
  };
  std::vector<Seen>* seen;
  explicit LookBack(std::vector<Seen>* list) : seen(list) { seen->reserve(1000); }
  std::vector<ImageSpec> check(std::span<const ImageSpec> in) override { return {in[0]}; }
  Outcome process(std::span<const Image* const> in, std::span<Image* const> out) noexcept override {
    const Image& last = *in[1];
    seen->push_back({last.valid(), last.reason, out[0]->sequence - last.sequence, last.valid() ? *last.row<uint8_t>(0) : -1});
    *out[0]->row<uint8_t>(0) = *in[0]->row<uint8_t>(0);
    return Outcome::valid;
  }
};

/// Blind in some frames, by the number in the image.
struct Sometimes final : ImageFilter {
  int* runs;
  int blind;
  Sometimes(int* counter, int blind_frame) : runs(counter), blind(blind_frame) {}
  ImageSpec accept(const ImageSpec& in) override { return in; }
  bool filter(const Image& in, Image& out) noexcept override {
    ++*runs;
    const int frame = *in.row<uint8_t>(0);
    *out.row<uint8_t>(0) = static_cast<uint8_t>(frame + 100);
    if (frame == blind) out.reason = Reason::no_floor_line;
    return frame != blind;
  }
};

/// camera -> back -> model, and back reads the last model.
struct DelayedTest : DriverTest {
  std::vector<LookBack::Seen> seen;
  int model_runs = 0;
  Handle back, model;

  void build_loop(int blind_frame = -1, const std::string& name = "model", const ImageSpec& as = spec) {
    camera = driver.add("camera", std::unique_ptr<ImageProcessor>(source), {}, Need::always);
    back = driver.add("back", std::make_unique<LookBack>(&seen), {camera, driver.last(name, as)});
    model = driver.add("model", std::make_unique<Sometimes>(&model_runs, blind_frame), {back});
    connect();
  }
  void steps(int count) {
    for (int i = 0; i < count; ++i) driver.step();
  }
};

TEST_F(DelayedTest, a_stage_reads_what_was_made_of_the_last_frame_further_down) {
  build_loop();
  driver.need_all();
  steps(3);
  ASSERT_EQ(seen.size(), 3u);
  EXPECT_FALSE(seen[0].valid);
  EXPECT_EQ(seen[0].reason, Reason::no_last_image);
  EXPECT_TRUE(image("back").valid()) << "a blind delayed image does not make its reader blind";
  for (int frame : {1, 2}) {
    EXPECT_TRUE(seen[static_cast<size_t>(frame)].valid);
    EXPECT_EQ(seen[static_cast<size_t>(frame)].pixel, 100 + frame - 1);
    EXPECT_EQ(seen[static_cast<size_t>(frame)].age, 1u);
  }
}

TEST_F(DelayedTest, begun_anew_there_is_no_last_frame_and_numbers_go_on) {
  build_loop();
  driver.need_all();
  steps(3);
  driver.begin_anew();
  steps(2);
  EXPECT_EQ(seen[3].reason, Reason::no_last_image);
  EXPECT_TRUE(seen[4].valid);
  EXPECT_EQ(image("back").sequence, 4u);
}

TEST_F(DelayedTest, a_recording_tells_the_number_of_the_next_frame_and_steps_are_counted_apart) {
  build_loop();
  driver.need_all();
  driver.set_sequence(70);
  steps(2);
  EXPECT_EQ(image("back").sequence, 71u);
  EXPECT_EQ(seen[1].age, 1u);
  EXPECT_EQ(driver.sequence(), 72u);
  EXPECT_EQ(driver.steps(), 2u);
}

TEST_F(DriverTest, a_stage_that_is_needed_runs_unwatched) {
  int runs = 0;
  camera = driver.add("camera", std::unique_ptr<ImageProcessor>(source), {}, Need::always);
  driver.add("model", std::make_unique<Sometimes>(&runs, -1), {camera});
  connect();
  driver.step();
  EXPECT_EQ(runs, 0);
  EXPECT_TRUE(driver.need("model"));
  EXPECT_FALSE(driver.need("truth/steering"));
  driver.step();
  EXPECT_EQ(runs, 1);
}

TEST_F(DelayedTest, the_last_image_is_the_drivers_own_and_not_what_was_published) {
  build_loop();
  driver.need_all();
  steps(1);
  *outlets["model"]->loan().row<uint8_t>(0) = 0;  // what a published block holds by now is nobody's business
  steps(1);
  EXPECT_EQ(seen[1].pixel, 100);
}

TEST_F(DelayedTest, a_blind_maker_is_a_blind_last_image_with_its_reason) {
  build_loop(1);
  driver.need_all();
  steps(4);
  EXPECT_TRUE(seen[1].valid);
  EXPECT_FALSE(seen[2].valid);
  EXPECT_EQ(seen[2].reason, Reason::no_floor_line);
  EXPECT_EQ(seen[2].age, 1u);
  EXPECT_TRUE(seen[3].valid);
}

TEST_F(DelayedTest, a_step_without_a_frame_leaves_it_as_it_is_and_the_sequence_tells_the_age) {
  source->bad = 1;
  build_loop();
  driver.need_all();
  steps(3);  // the second is blind: nobody runs
  ASSERT_EQ(seen.size(), 2u);
  EXPECT_TRUE(seen[1].valid);
  EXPECT_EQ(seen[1].pixel, 100);
  EXPECT_EQ(seen[1].age, 2u);
}

TEST_F(DelayedTest, an_input_that_may_be_blind_blinds_nobody) {
  camera = driver.add("camera", std::unique_ptr<ImageProcessor>(source), {}, Need::always);
  const Handle guess = driver.add("guess", std::make_unique<Sometimes>(&model_runs, 1), {camera});
  std::vector<LookBack::Seen> first_seen;
  driver.add("first", std::make_unique<LookBack>(&first_seen), {even_blind(guess), even_blind(guess)}, Need::always);
  driver.add("reader", std::make_unique<LookBack>(&seen), {camera, even_blind(guess)}, Need::always);
  connect();
  steps(3);
  ASSERT_EQ(seen.size(), 3u);
  ASSERT_EQ(first_seen.size(), 3u) << "also where its first input is blind";
  EXPECT_EQ(image("first").timestamp_ns, image("camera").timestamp_ns);
  EXPECT_TRUE(image("reader").valid());
  EXPECT_EQ(seen[0].age, 0u) << "it is of this frame";
  EXPECT_FALSE(seen[1].valid);
  EXPECT_EQ(seen[1].reason, Reason::no_floor_line);
  EXPECT_TRUE(seen[2].valid);
}

TEST_F(DelayedTest, a_running_reader_makes_the_maker_run) {
  build_loop();
  steps(1);
  EXPECT_EQ(model_runs, 0) << "nobody watches";
  outlets["back"]->watch(true);
  steps(2);
  EXPECT_EQ(model_runs, 2);
  EXPECT_FALSE(seen[0].valid) << "the maker did not run in the step before";
  EXPECT_TRUE(seen[1].valid);
  outlets["back"]->watch(false);
  steps(1);
  outlets["back"]->watch(true);
  steps(1);
  EXPECT_EQ(seen[2].reason, Reason::no_last_image) << "an image of longer ago is not handed out";
}

TEST_F(DelayedTest, the_maker_gets_its_own_inputs_also_where_nobody_else_needs_them) {
  camera = driver.add("camera", std::unique_ptr<ImageProcessor>(source), {}, Need::always);
  back = driver.add("back", std::make_unique<LookBack>(&seen), {camera, driver.last("far", spec)});
  near = driver.add("near", std::make_unique<AddOne>(&near_runs), {camera});
  far = driver.add("far", std::make_unique<AddOne>(&far_runs), {near});
  connect();
  outlets["back"]->watch(true);
  steps(2);
  EXPECT_EQ(near_runs, 2);
  EXPECT_EQ(far_runs, 2);
  EXPECT_EQ(seen[1].pixel, 2);
}

TEST_F(DelayedTest, chains_of_looking_back_run_all_their_makers) {
  std::vector<LookBack::Seen> second;
  camera = driver.add("camera", std::unique_ptr<ImageProcessor>(source), {}, Need::always);
  driver.add("c", std::make_unique<AddOne>(&far_runs), {camera});
  driver.add("b", std::make_unique<LookBack>(&second), {camera, driver.last("c", spec)});
  driver.add("a", std::make_unique<LookBack>(&seen), {camera, driver.last("b", spec)});
  driver.add("d", std::make_unique<AddOne>(&near_runs), {camera});
  connect();
  outlets["a"]->watch(true);
  steps(2);
  EXPECT_EQ(second.size(), 2u);
  EXPECT_EQ(far_runs, 2);
  EXPECT_EQ(near_runs, 0) << "nobody reads it";
  EXPECT_TRUE(second[1].valid && seen[1].valid);
}

TEST_F(DelayedTest, who_runs_after_the_maker_still_gets_the_last_frame) {
  camera = driver.add("camera", std::unique_ptr<ImageProcessor>(source), {}, Need::always);
  near = driver.add("near", std::make_unique<AddOne>(&near_runs), {camera});
  driver.add("back", std::make_unique<LookBack>(&seen), {near, driver.last("near", spec)});
  driver.add("itself", std::make_unique<LookBack>(&seen), {camera, driver.last("itself", spec)});
  connect();
  driver.need_all();
  steps(3);
  EXPECT_EQ(seen[4].pixel, 2);  // near of the second frame
  EXPECT_EQ(seen[5].pixel, 1);
}

TEST_F(DelayedTest, looking_back_holds_up_no_publication) {
  build_loop();
  driver.need_all();
  steps(2);
  EXPECT_EQ(published, (std::vector<std::string>{"camera", "back", "model", "camera", "back", "model"}));
}

TEST_F(DelayedTest, a_name_that_nobody_makes_is_refused_with_both_ends_and_those_there_are) {
  try {
    build_loop(-1, "modle");
    FAIL();
  } catch (const FormatError& error) {
    EXPECT_STREQ(error.what(), "stage 'back' reads the last 'modle', which nobody makes; there are camera, back, model");
  }
}

TEST_F(DelayedTest, another_format_than_expected_is_refused_with_both) {
  try {
    build_loop(-1, "model", record_spec<FloorModel>());
    FAIL();
  } catch (const FormatError& error) {
    EXPECT_STREQ(error.what(), "stage 'back' reads the last 'model' as record 416x1, it is gray8 8x4");
  }
}

TEST_F(DelayedTest, two_records_are_told_apart_by_type) {
  camera = driver.add("camera", std::unique_ptr<ImageProcessor>(source), {}, Need::always);
  driver.add("back", std::make_unique<LookBack>(&seen), {camera, driver.last("record", record_spec<Heartbeat>())});
  driver.add("record", std::make_unique<ToRecord>(), {camera});
  try {
    connect();
    FAIL();
  } catch (const FormatError& error) {
    EXPECT_STREQ(error.what(), "stage 'back' reads the last 'record' as record 32x1 of type 3, it is record 416x1 of type 1");
  }
}

TEST_F(DelayedTest, the_first_input_is_of_this_frame) {
  camera = driver.add("camera", std::unique_ptr<ImageProcessor>(source), {}, Need::always);
  try {
    driver.add("back", std::make_unique<LookBack>(&seen), {driver.last("camera", spec), camera});
    FAIL();
  } catch (const FormatError& error) {
    EXPECT_STREQ(error.what(), "stage 'back': its first input is the last 'camera', needed is one of this frame: it gives frame and time");
  }
}

/// A source whose picture depends on what the tree made of the last frame.
struct Heeding final : ImageSource {
  std::vector<int> heard;
  std::vector<ImageSpec> open() override { return {spec}; }
  std::vector<ImageSpec> heeds() const override { return {spec}; }
  void heed(std::span<const Image* const> last) noexcept override {
    heard.push_back(last[0]->valid() ? *last[0]->row<uint8_t>(0) : -static_cast<int>(last[0]->reason));
  }
  Outcome grab(std::span<Image* const> out) noexcept override {
    out[0]->timestamp_ns = 1000 * static_cast<int64_t>(heard.size());
    *out[0]->row<uint8_t>(0) = static_cast<uint8_t>(heard.empty() || heard.back() < 0 ? 1 : 2 * heard.back());
    return heard.size() == 3 ? Outcome::invalid : Outcome::valid;
  }
};

TEST_F(DelayedTest, a_source_may_heed_what_was_made_of_the_last_frame) {
  auto* heeding = new Heeding;
  heeding->heard.reserve(10);
  camera = driver.add("camera", std::unique_ptr<ImageProcessor>(heeding), {driver.last("near", spec)}, Need::always);
  near = driver.add("near", std::make_unique<AddOne>(&near_runs), {camera});
  connect();
  steps(5);
  // 1 -> 2, 4 -> 5, then a blind step, which leaves the last frame as it was.
  EXPECT_EQ(heeding->heard, (std::vector<int>{-static_cast<int>(Reason::no_last_image), 2, 5, 5, 11}));
  EXPECT_EQ(driver.blind_steps(), 1u);
  EXPECT_EQ(near_runs, 4) << "its maker runs for it, and is blind where the source is";
  EXPECT_EQ(image("camera").timestamp_ns, 5000) << "the source gives the time, not what it heeds";
  delete source;
}

TEST_F(DelayedTest, a_source_is_refused_what_is_of_this_frame_and_what_it_does_not_heed) {
  camera = driver.add("camera", std::unique_ptr<ImageProcessor>(source), {}, Need::always);
  const auto refused = [&](std::unique_ptr<ImageProcessor> stage, std::vector<Handle> inputs) -> std::string {
    try {
      driver.add("second", std::move(stage), std::move(inputs));
    } catch (const FormatError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(refused(std::make_unique<Heeding>(), {camera}),
            "stage 'second': a source, its input 'camera' is of this frame; needed is one of the last: the source begins the frame");
  EXPECT_EQ(refused(std::make_unique<Heeding>(), {}), "stage 'second': takes 1 of the last frame, was given 0");
  EXPECT_EQ(refused(std::make_unique<Source>(), {driver.last("camera", spec)}),
            "stage 'second' of the last 'camera' (gray8 8x4): takes no input, was given 1");
  EXPECT_NE(refused(std::make_unique<Heeding>(), {driver.last("camera", record_spec<FloorModel>())}), "");
}

TEST_F(DelayedTest, a_refused_stage_names_its_delayed_input) {
  camera = driver.add("camera", std::unique_ptr<ImageProcessor>(source), {}, Need::always);
  try {
    driver.add("wrong", std::make_unique<AddOne>(&far_runs), {camera, driver.last("model", record_spec<FloorModel>())});
    FAIL();
  } catch (const FormatError& error) {
    EXPECT_STREQ(error.what(),
                 "stage 'wrong' of 'camera' (gray8 8x4), the last 'model' (record 416x1): the input is record, needed is gray8");
  }
}

TEST_F(DelayedTest, catalogue_and_graph_show_the_way_back) {
  camera = driver.add("camera", std::unique_ptr<ImageProcessor>(source), {}, Need::always);
  back = driver.add("back", std::make_unique<LookBack>(&seen), {camera, driver.last("model", spec)});
  model = driver.add("model", std::make_unique<Sometimes>(&model_runs, -1), {back});
  const std::string edge = "\"model\" -> \"back\" [label=\"gray8 8x4\", style=dashed";
  std::ostringstream before, after;
  driver.write_dot(before);  // main writes it before connect()
  EXPECT_NE(before.str().find(edge), std::string::npos) << before.str();
  connect();
  driver.write_dot(after);
  EXPECT_EQ(after.str(), before.str());
  EXPECT_EQ(driver.topics()[1].parents[1].topic, model.topic);
  steps(1);
  driver.beat();
  const Catalogue* catalogue = record_of<Catalogue>(image("catalogue"));
  EXPECT_EQ(catalogue->entries[1].parents[0], 0);
  EXPECT_EQ(catalogue->entries[1].parents[1], delayed_parent(2));
  EXPECT_EQ(delayed_parent(catalogue->entries[1].parents[1]), 2);
  EXPECT_LT(catalogue->entries[1].parents[1], -1) << "a reader that does not know it takes it for none";
}

TEST(DelayedRuns, two_runs_are_equal) {
  const auto run = [](Driver& one) {
    std::vector<LookBack::Seen> saw;
    int runs = 0;
    auto* camera_source = new Source;
    camera_source->bad = 4;
    const Handle first = one.add("camera", std::unique_ptr<ImageProcessor>(camera_source));
    const Handle second = one.add("back", std::make_unique<LookBack>(&saw), {first, one.last("model", spec)});
    one.add("model", std::make_unique<Sometimes>(&runs, 7), {second});
    one.connect([](const std::string&, const ImageSpec& s) { return std::make_unique<BufferOutlet>(s); });
    one.need_all();
    for (int i = 0; i < 20; ++i) one.step();
    std::vector<uint64_t> all;
    for (const auto& s : saw) all.insert(all.end(), {s.valid, static_cast<uint64_t>(s.reason), s.age, static_cast<uint64_t>(s.pixel)});
    return all;
  };
  Driver one(1), other(2);
  const auto first = run(one);
  EXPECT_EQ(first.size(), 19u * 4);
  EXPECT_EQ(first, run(other));
}

TEST_F(DelayedTest, looking_back_takes_nothing_from_the_heap) {
  build_loop(50);
  driver.set_viewer(nullptr);
  driver.need_all();
  steps(2);
  const uint64_t before = allocations_of_this_thread();
  for (int i = 0; i < 100; ++i) {
    driver.step();
    driver.beat();
  }
  EXPECT_EQ(allocations_of_this_thread(), before);
}

}  // namespace
}  // namespace vdisp
