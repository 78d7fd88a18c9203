// asked_flight_test.cpp: dump-flight tells what became of its own folder, whatever else the flight recorder writes.
// SPDX-License-Identifier: Apache-2.0
#include "probe/asked_flight.h"

#include <gtest/gtest.h>

namespace vdisp {
namespace {

using State = AskedFlight::State;

/// As the flight recorder tells it.
struct Recorder {
  RecorderStatus status{};
  void begin(FlightCause cause) {
    ++status.asked;
    status.cause = cause;
    status.writing = 1;
  }
  void end(bool good, const char* text) {
    ++(good ? status.written : status.failed);
    status.writing = 0;
    std::fill(std::begin(status.text), std::end(status.text), '\0');
    std::string_view(text).copy(status.text, sizeof status.text - 1);
  }
};

struct AskedFlightTest : testing::Test {
  Recorder recorder;
  const char *bump = "/var/flight-20260131-235959-123-bump", *ours = "/var/flight-20260131-235959-999-asked",
             *full = "/var: 3 MiB are free";
};

TEST_F(AskedFlightTest, a_folder_is_awaited_written_and_told) {
  recorder.begin(FlightCause::bump), recorder.end(false, full);  // long ago
  AskedFlight asked(recorder.status);
  EXPECT_EQ(asked.see(recorder.status), State::awaited);
  recorder.begin(FlightCause::asked);
  EXPECT_EQ(asked.see(recorder.status), State::writing);
  recorder.end(true, ours);
  EXPECT_EQ(asked.see(recorder.status), State::written);
  EXPECT_EQ(asked.text(), ours);
}

TEST_F(AskedFlightTest, one_that_failed_meanwhile_for_a_bump_is_not_ours) {
  recorder.begin(FlightCause::bump);
  AskedFlight asked(recorder.status);
  EXPECT_EQ(asked.see(recorder.status), State::awaited);
  recorder.end(false, full), recorder.begin(FlightCause::asked);
  EXPECT_EQ(asked.see(recorder.status), State::writing);
  recorder.end(true, ours);
  EXPECT_EQ(asked.see(recorder.status), State::written);
  EXPECT_EQ(asked.text(), ours);
}

TEST_F(AskedFlightTest, one_that_was_written_meanwhile_for_a_bump_does_not_hide_that_ours_failed) {
  AskedFlight asked(recorder.status);
  recorder.begin(FlightCause::bump);  // before the order is heard
  EXPECT_EQ(asked.see(recorder.status), State::awaited);
  recorder.end(true, bump), recorder.begin(FlightCause::asked), recorder.end(false, full);
  EXPECT_EQ(asked.see(recorder.status), State::failed) << "both since the last look";
  EXPECT_EQ(asked.text(), full);
}

TEST_F(AskedFlightTest, an_order_that_was_joined_to_another_cause_gets_its_folder) {
  recorder.begin(FlightCause::floor_lost);
  AskedFlight asked(recorder.status);
  recorder.end(true, "/var/flight-20260131-235959-001-floor_lost"), recorder.begin(FlightCause::bump);  // it waited when the order came
  EXPECT_EQ(asked.see(recorder.status), State::awaited);
  recorder.end(true, bump);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(asked.see(recorder.status), State::awaited) << "the order may not be heard yet";
  EXPECT_EQ(asked.see(recorder.status), State::written);
  EXPECT_EQ(asked.text(), bump);
}

TEST_F(AskedFlightTest, a_look_that_comes_too_late_does_not_tell_another_folder) {
  AskedFlight asked(recorder.status);
  recorder.begin(FlightCause::asked);
  asked.see(recorder.status);
  recorder.end(true, ours), recorder.begin(FlightCause::bump), recorder.end(true, bump);
  EXPECT_EQ(asked.see(recorder.status), State::overtaken);
}

}  // namespace
}  // namespace vdisp
