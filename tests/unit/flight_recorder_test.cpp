// flight_recorder_test.cpp: the ring keeps the last steps, is written from its oldest on, and loses what it must and no more.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/record/flight_recorder.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstring>
#include <fstream>
#include <thread>

#include "ipc/outlet.h"
#include "tests/support/count_allocations.h"
#include "tests/support/temporary_folder.h"

namespace vdisp {
namespace {

namespace fs = std::filesystem;

constexpr ImageSpec camera{Pixel::gray8, 0, 640, 409};  // two of them are half a MiB, less a bit: two steps in each MiB
constexpr int64_t period = 100'000'000;

struct FlightRecorderTest : testing::Test {
  TemporaryFolder folder;
  Config config;
  BufferOutlet left{camera}, right{camera}, event{record_spec<Events>()}, floor{record_spec<FloorModel>()};
  uint64_t sequence = 0;

  FlightRecorderTest() {
    config.recorder.seconds = 3600;
    config.recorder.memory = 5;
    config.recorder.folder = (folder / "flight").string();
    config.recorder.free = 0;
    for (BufferOutlet* outlet : {&left, &right}) std::fill_n(outlet->loan().row<uint8_t>(0), camera.stride() * camera.height, uint8_t{0});
    make_record<Events>(event.loan());
    event.loan().set_blind(Reason::no_event);
    make_record<FloorModel>(floor.loan());
  }
  std::unique_ptr<FlightRecorder> recorder() {
    RecordingInfo info;
    info.width = camera.width, info.height = camera.height;
    return std::make_unique<FlightRecorder>(config, camera, info, [] {
      return std::vector<std::pair<std::string, std::string>>{{"vdisp.cfg", "[main]\n"}};
    });
  }
  void step(FlightRecorder& recorder, bool there = true, bool floor_there = true, const char* label = nullptr) {
    const int64_t now = static_cast<int64_t>(sequence) * period;
    for (Image* image : {&left.loan(), &right.loan(), &event.loan(), &floor.loan()}) image->sequence = sequence, image->ready_ns = now;
    for (Image* image : {&left.loan(), &right.loan()}) {
      image->timestamp_ns = now;
      image->state = there ? ImageState::valid : ImageState::blind;
      image->reason = there ? Reason::none : Reason::no_frame;
      image->row<uint8_t>(0)[0] = static_cast<uint8_t>(sequence);
    }
    floor.loan().state = floor_there ? ImageState::valid : ImageState::blind;
    Events& events = *event.loan().row<Events>(0);
    events.tally.in_step = label ? 1 : 0;
    events.count = label ? 1 : 0;
    if (label) std::strcpy(events.entries[0].label, label);
    recorder.see("camera/left", left.loan());
    recorder.see("camera/right", right.loan());
    recorder.see("in/event", event.loan());
    recorder.see("floor_model", floor.loan());
    recorder.finish_step(now);
    ++sequence;
  }
  RecorderStatus status(const FlightRecorder& recorder) {
    RecorderStatus status{};
    recorder.tell(status);
    return status;
  }
  /// Steps go on while it writes, as a daemon's would.
  RecorderStatus until_written(FlightRecorder& recorder, uint64_t count) {
    for (int i = 0; i < 2000; ++i) {
      step(recorder);
      if (status(recorder).written + status(recorder).failed >= count) break;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return status(recorder);
  }
};

TEST_F(FlightRecorderTest, memory_bounds_it_and_the_newest_steps_are_written_in_order) {
  const auto flight = recorder();
  const uint64_t room = status(*flight).room;
  EXPECT_TRUE(room == 9 || room == 10) << room;
  for (int i = 0; i < 25; ++i) step(*flight);
  EXPECT_EQ(status(*flight).held, room);
  flight->ask(FlightCause::signal);
  step(*flight);
  const RecorderStatus told = until_written(*flight, 1);
  ASSERT_EQ(told.written, 1u) << told.text;
  EXPECT_EQ(told.cause, FlightCause::signal);
  const Recording recording(told.text);
  ASSERT_EQ(recording.pairs().size(), room);
  EXPECT_EQ(recording.steps().back().sequence, 25u);
  EXPECT_EQ(recording.steps().front().sequence, 26 - room);
  EXPECT_FALSE(recording.configuration().empty());
  BufferOutlet a(camera), b(camera);
  for (size_t i = 0; i < recording.pairs().size(); ++i) {
    recording.read(i, a.loan(), b.loan());
    EXPECT_EQ(a.loan().row<uint8_t>(0)[0], 26 - room + i) << "no step was written over before it was written out";
  }
}

TEST_F(FlightRecorderTest, seconds_bound_what_is_written) {
  config.recorder.seconds = 0.35;
  const auto flight = recorder();
  for (int i = 0; i < 9; ++i) step(*flight);
  flight->ask(FlightCause::asked);
  step(*flight);
  const RecorderStatus told = until_written(*flight, 1);
  EXPECT_EQ(Recording(told.text).steps().size(), 4u) << "of 0.1 s each";
}

TEST_F(FlightRecorderTest, a_step_whose_place_is_still_to_be_written_is_lost_and_counted_and_the_written_ones_are_right) {
  const auto flight = recorder();
  for (int i = 0; i < 20; ++i) step(*flight);
  flight->ask(FlightCause::signal);
  step(*flight);
  for (int i = 0; i < 40; ++i) step(*flight);  // faster than any disk encodes
  EXPECT_GT(status(*flight).lost, 0u);
  const RecorderStatus told = until_written(*flight, 1);
  EXPECT_EQ(Recording(told.text).steps().back().sequence, 20u);
}

TEST_F(FlightRecorderTest, camera_and_floor_are_lost_after_three_steps_and_a_bump_at_once) {
  const auto flight = recorder();
  step(*flight);
  step(*flight, false), step(*flight, false);
  step(*flight);
  EXPECT_EQ(status(*flight).asked, 0u);
  for (int i = 0; i < 3; ++i) step(*flight, true, false);
  EXPECT_EQ(status(*flight).cause, FlightCause::floor_lost);
  config.recorder.seconds = 0.1;
  until_written(*flight, 1);
  for (int i = 0; i < 3; ++i) step(*flight, false, false);
  EXPECT_EQ(status(*flight).cause, FlightCause::camera_lost);
  until_written(*flight, 2);
  step(*flight, true, true, "bumper left");
  EXPECT_EQ(status(*flight).cause, FlightCause::bump);
  EXPECT_EQ(until_written(*flight, 3).written, 3u);
}

TEST_F(FlightRecorderTest, what_flickers_does_not_write_again_within_its_seconds_but_who_asks_is_served) {
  const auto flight = recorder();
  step(*flight);
  for (int i = 0; i < 3; ++i) step(*flight, true, false);
  until_written(*flight, 1);
  for (int again = 0; again < 5; ++again) {
    for (int i = 0; i < 3; ++i) step(*flight, true, false);
    step(*flight);
  }
  EXPECT_EQ(status(*flight).asked, 1u);
  step(*flight, true, true, "dump-flight");
  EXPECT_EQ(until_written(*flight, 2).written, 2u);
}

TEST_F(FlightRecorderTest, a_folder_that_cannot_be_made_is_told_and_it_goes_on) {
  std::ofstream(config.recorder.folder) << "a file";
  const auto flight = recorder();
  step(*flight);
  flight->ask(FlightCause::signal);
  step(*flight);
  const RecorderStatus told = until_written(*flight, 1);
  EXPECT_EQ(told.failed, 1u);
  EXPECT_NE(std::string(told.text).find(config.recorder.folder), std::string::npos) << told.text;
  fs::remove(config.recorder.folder);
  flight->ask(FlightCause::signal);
  step(*flight);
  EXPECT_EQ(until_written(*flight, 2).written, 1u);
}

TEST_F(FlightRecorderTest, nothing_old_is_deleted_for_a_folder_that_cannot_be_written) {
  config.recorder.keep = 1;
  const auto flight = recorder();
  flight->ask(FlightCause::asked);
  step(*flight);
  const std::string old = until_written(*flight, 1).text;
  config.recorder.free = 1 << 30;  // MiB
  flight->ask(FlightCause::asked);
  step(*flight);
  EXPECT_EQ(until_written(*flight, 2).failed, 1u);
  EXPECT_TRUE(fs::exists(old));
}

TEST(FlightFolders, the_new_one_stays_even_where_the_clock_went_back_and_a_broken_one_only_where_there_is_a_place) {
  const TemporaryFolder place;
  const FlightRoom room{place.path(), 2, 0};
  const auto make = [&](const char* name) { return fs::create_directory(place / name), place / name; };
  const auto first = make("flight-20260101-000000-000-bump"), second = make("flight-20260102-000000-000-bump"),
             broken = make("flight-20260103-000000-000-bump");
  drop_broken(room, broken);
  EXPECT_FALSE(fs::exists(broken));
  EXPECT_TRUE(fs::exists(first) && fs::exists(second));
  const auto whole = make("flight-20200101-000000-000-bump");
  drop_oldest(room, whole);
  EXPECT_TRUE(fs::exists(whole) && fs::exists(second));
  EXPECT_FALSE(fs::exists(first));
}

TEST_F(FlightRecorderTest, only_so_many_folders_are_kept) {
  config.recorder.keep = 2;
  fs::create_directories(folder / "flight/flight-plan");
  const auto flight = recorder();
  std::vector<std::string> names;
  for (uint64_t i = 1; i <= 4; ++i) {
    step(*flight);
    flight->ask(FlightCause::asked);
    step(*flight);
    names.push_back(until_written(*flight, i).text);
  }
  EXPECT_FALSE(fs::exists(names[0]));
  EXPECT_FALSE(fs::exists(names[1]));
  EXPECT_TRUE(fs::exists(names[2]) && fs::exists(names[3]));
  EXPECT_TRUE(fs::exists(folder / "flight/flight-plan"));
}

TEST_F(FlightRecorderTest, the_loop_takes_nothing_from_the_heap) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "the sanitizer has its own malloc";
#endif
  const auto flight = recorder();
  step(*flight);
  const uint64_t before = allocations_of_this_thread();
  for (int i = 0; i < 50; ++i) step(*flight, i % 10 < 7);
  EXPECT_EQ(allocations_of_this_thread() - before, 0u);
}

}  // namespace
}  // namespace vdisp
