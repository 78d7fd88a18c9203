// recording_test.cpp: what is recorded reads back exactly, what was cut off is left out, and what is broken is refused in one line.
// SPDX-License-Identifier: Apache-2.0
#include "ipc/recording.h"

#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include "ipc/outlet.h"
#include "ipc/recording_text.h"
#include "ipc/step_taker.h"
#include "tests/support/temporary_folder.h"

namespace vdisp {
namespace {

namespace fs = std::filesystem;

constexpr int width = 70, height = 20, stride = 128;

RecordingInfo info() { return {"vdispd 0", "sim", "drive", 3, 7, width, height, true}; }

/// Noise, another for each number.
std::vector<uint8_t> picture(unsigned number) {
  std::minstd_rand random(number + 1);
  std::vector<uint8_t> pixels(stride * height);
  for (uint8_t& pixel : pixels) pixel = static_cast<uint8_t>(random() >> 8);
  return pixels;
}

RecordedStep step(uint64_t sequence) {
  RecordedStep step;
  step.sequence = sequence;
  step.timestamp_ns = static_cast<int64_t>(sequence) * 33'333'333;
  step.flags = flag_synthetic;
  step.odometry.record.x = 0.1 * static_cast<double>(sequence);
  step.odometry.record.z = std::nan("");
  step.imu.reason = Reason::no_imu;
  return step;
}

/// Bytes of what the tree would see, NaN and all.
bool same(const RecordedStep& a, const RecordedStep& b) {
  return recording::step_line(a, true) == recording::step_line(b, true) &&
         std::memcmp(a.event.record.entries, b.event.record.entries, sizeof a.event.record.entries) == 0;
}

void write(const fs::path& folder, unsigned steps, Label label = Label::forward) {
  RecordingWriter writer(folder, info());
  for (unsigned i = 0; i < steps; ++i) {
    const auto left = picture(2 * i), right = picture(2 * i + 1);
    const RecordedViews views{left.data(), right.data(), stride, label, 0.25, -1.0 / 3};
    writer.add(step(i), &views);
  }
}

std::string text_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

void replace(const fs::path& path, const std::string& from, const std::string& to) {
  std::string text = text_of(path);
  const size_t at = text.find(from);
  ASSERT_NE(at, std::string::npos) << from << " in " << text;
  std::ofstream(path, std::ios::binary) << text.replace(at, from.size(), to);
}

struct RecordingTest : testing::Test {
  TemporaryFolder temporary;
  fs::path folder = temporary / "drive";

  std::string refusal() const {
    try {
      const Recording recording(folder);
      for (size_t i = 0; i < recording.pairs().size(); ++i) {
        BufferOutlet left({Pixel::gray8, 0, width, height}), right({Pixel::gray8, 0, width, height});
        recording.read(i, left.loan(), right.loan());
      }
    } catch (const RecordingError& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      return error.what();
    }
    return "nothing refused";
  }
  void expect_refused(const std::string& words) const {
    const std::string found = refusal();
    EXPECT_NE(found.find(words), std::string::npos) << found;
  }
};

TEST_F(RecordingTest, pairs_read_back_pixel_for_pixel_with_their_labels) {
  write(folder, 4, Label::right);
  const Recording recording(folder);
  ASSERT_EQ(recording.pairs().size(), 4u);
  EXPECT_EQ(recording.info().seed, 3u);
  EXPECT_TRUE(recording.info().synthetic);
  EXPECT_EQ(recording.pairs()[2], (RecordedPair{66'666'666, Label::right, 0.25, -1.0 / 3}));
  EXPECT_EQ(recording.left(2).filename(), "66666666_right.png");
  BufferOutlet left({Pixel::gray8, 0, width, height}), right({Pixel::gray8, 0, width, height});
  recording.read(2, left.loan(), right.loan());
  for (int y = 0; y < height; ++y) {
    EXPECT_EQ(std::memcmp(left.loan().row<uint8_t>(y), &picture(4)[static_cast<size_t>(y) * stride], width), 0);
    EXPECT_EQ(std::memcmp(right.loan().row<uint8_t>(y), &picture(5)[static_cast<size_t>(y) * stride], width), 0);
  }
}

TEST_F(RecordingTest, the_index_is_as_documented) {
  write(folder, 1);
  EXPECT_EQ(text_of(folder / "index.csv"),
            "timestamp_ns,label,left,right,speed,turn_rate\n0,forward,left/0_forward.png,right/0_forward.png,0.25,-0.3333333333333333\n");
}

TEST_F(RecordingTest, steps_read_back_to_the_last_bit_with_blind_ones_and_events) {
  std::vector<RecordedStep> steps;
  std::mt19937_64 random(1);
  const auto number = [&] { return std::ldexp(static_cast<double>(static_cast<int64_t>(random())), static_cast<int>(random() % 80) - 90); };
  Events events{};
  for (unsigned i = 0; i < 40; ++i) {
    RecordedStep s = step(100 + i + (i > 20 ? 5 : 0));  // a gap: steps that were not recorded
    for (double* value : {&s.odometry.record.x, &s.odometry.record.yaw, &s.odometry.record.age_s, &s.imu.record.rate[2],
                          &s.imu.record.acceleration[0], &s.drive.record.turn_rate, &s.event.record.age_s})
      *value = number();
    s.drive.record.speed = i % 2 ? -0.0 : INFINITY;
    s.odometry.record.tally = {random(), random(), Refusal::jump, 3};
    s.imu.flags = flag_synthetic;
    events.tally.in_step = i % 5 == 4 ? 11 : i % 2;
    for (unsigned n = 0; n < events.tally.in_step; ++n) {
      std::copy_backward(events.entries, events.entries + 7, events.entries + 8);
      events.entries[0] = {static_cast<int64_t>(random() >> 1), {}};
      std::snprintf(events.entries[0].label, 48, n % 2 ? "a \"quoted\", %u" : "bump,,%u", i);
      events.count = std::min(events.count + 1, 8u);
    }
    s.event.record = events;
    if (i % 7 == 3) s.reason = Reason::no_frame;
    steps.push_back(s);
  }
  RecordingWriter writer(folder, info());
  const auto left = picture(0), right = picture(1);
  const RecordedViews views{left.data(), right.data(), stride, Label::none};
  for (const RecordedStep& s : steps) writer.add(s, s.has_pair() ? &views : nullptr);
  const Recording recording(folder);
  ASSERT_EQ(recording.steps().size(), steps.size());
  EXPECT_EQ(recording.cut_off(), 0u);
  for (size_t i = 0; i < steps.size(); ++i) {
    EXPECT_TRUE(same(recording.steps()[i], steps[i]))
        << i << "\n"
        << recording::step_line(recording.steps()[i], true) << recording::step_line(steps[i], true);
    const double a = recording.steps()[i].drive.record.speed, b = steps[i].drive.record.speed;
    EXPECT_EQ(std::memcmp(&a, &b, sizeof a), 0);
  }
  EXPECT_TRUE(std::isnan(recording.pairs()[0].speed));
}

TEST_F(RecordingTest, a_folder_that_holds_a_recording_is_not_written_into) {
  write(folder, 2);
  try {
    RecordingWriter writer(folder, info());
    FAIL();
  } catch (const WriteError& error) {
    EXPECT_EQ(error.exit_code, 73);
  }
  EXPECT_EQ(Recording(folder).pairs().size(), 2u);
}

TEST_F(RecordingTest, pairs_whose_time_does_not_rise_end_the_recording_and_leave_it_whole) {
  write(folder, 0);
  const fs::path other = temporary / "other";
  RecordingWriter writer(other, info());
  const auto left = picture(0), right = picture(1);
  const RecordedViews views{left.data(), right.data(), stride};
  writer.add(step(3), &views);
  EXPECT_THROW(writer.add(step(3), &views), WriteError);
  EXPECT_EQ(Recording(other).pairs().size(), 1u);
}

TEST_F(RecordingTest, wherever_a_write_is_cut_off_the_whole_pairs_before_it_remain) {
  write(folder, 3);
  const std::string index = text_of(folder / "index.csv"), inputs = text_of(folder / "inputs.csv");
  const size_t head = index.find('\n') + 1, steps_head = inputs.find('\n') + 1;
  for (size_t length = head; length < index.size(); ++length) {
    std::ofstream(folder / "index.csv", std::ios::binary) << index.substr(0, length);
    const Recording recording(folder);
    EXPECT_EQ(recording.pairs().size(),
              static_cast<size_t>(std::count(index.begin(), index.begin() + static_cast<long>(length), '\n')) - 1);
    EXPECT_EQ(recording.steps().size(), recording.pairs().size());
    EXPECT_GT(recording.cut_off(), 0u);
  }
  const size_t second = index.find('\n', head) + 1;
  std::ofstream(folder / "index.csv", std::ios::binary) << index.substr(0, second);
  std::ofstream(folder / "inputs.csv", std::ios::binary) << inputs.substr(0, inputs.find('\n', steps_head) + 30);
  EXPECT_EQ(Recording(folder).steps().size(), 1u);
}

TEST_F(RecordingTest, the_last_pairs_whose_pictures_never_reached_the_disk_are_left_out) {
  for (const char* how : {"empty", "short", "zero"}) {
    fs::remove_all(folder);
    write(folder, 4);
    const fs::path last = folder / "left/99999999_forward.png", before = folder / "right/66666666_forward.png";
    fs::resize_file(last, how[0] == 'e' ? 0 : how[0] == 's' ? 100 : fs::file_size(last));
    if (how[0] == 'z') std::ofstream(last, std::ios::binary) << std::string(900, '\0');
    fs::resize_file(before, 0);
    const Recording recording(folder);
    EXPECT_EQ(recording.pairs().size(), 2u) << how;
    EXPECT_EQ(recording.steps().size(), 2u);
    EXPECT_EQ(recording.cut_off(), 2u);
  }
}

TEST_F(RecordingTest, what_is_broken_is_refused_in_one_line_that_says_what_would_be_right) {
  expect_refused("no such folder");
  const auto broken = [&](const auto& damage, const std::string& words) {
    fs::remove_all(folder);
    write(folder, 3);
    damage();
    expect_refused(words);
  };
  const auto index = folder / "index.csv";
  broken([&] { fs::remove(folder / "right/33333333_forward.png"); }, "33333333_forward.png is missing; needed are both pictures");
  broken([&] { fs::remove(folder / "right/66666666_forward.png"); }, "is missing");
  broken([&] { replace(index, "\n33333333,forward,left/33333333_forward.png", "\n33333333,forward,left/up.png"); },
         "line 3: the picture is called 'left/up.png', by time and label it must be left/33333333_forward.png");
  broken([&] { replace(index, "left/0_forward.png", "../../etc/passwd"); }, "it must be left/0_forward.png");
  broken([&] { replace(index, "\n0,forward", "\n0,backward"); },
         "line 2: label 'backward' is unknown, must be forward, left, right or none");
  broken([&] { replace(index, "\n33333333,", "\n-1,"); }, "must be a whole number from 0");
  broken([&] { replace(index, "0.25", "fast"); }, "speed = 'fast', must be a number");
  broken([&] { replace(index, "timestamp_ns,", "time,"); }, "line 1: found 'time,");
  broken([&] { replace(index, "0.25,", ""); }, "must be the six fields");
  broken([&] { replace(folder / "recording.json", "\"width\": 70", "\"width\": 71"); }, "is 70x20, the recording is 71x20");
  broken([&] { replace(folder / "recording.json", "\"version\": 1", "\"version\": 9"); }, "is of version 9, known is 1");
  broken([&] { fs::remove(folder / "recording.json"); }, "no such file; needed is a recording");
  broken([&] { std::ofstream(folder / "recording.json") << "{"; }, "is no description of a recording");
  broken([&] { std::ofstream(folder / "left/0_forward.png") << std::string(500, 'x'); }, "left/0_forward.png is no PNG");
  broken([&] { fs::resize_file(folder / "left/0_forward.png", 300); }, "left/0_forward.png: is damaged");
  broken([&] { replace(folder / "inputs.csv", "\n1,33333333,none", "\n1,33333334,none"); }, "has a pair of time 33333334");
  broken([&] { replace(folder / "inputs.csv", "\n1,33333333,none", "\n1,33333333,no_frame"); }, "the next in index.csv is 33333333");
  broken([&] { replace(folder / "inputs.csv", ",no_imu,", ",no_idea,"); }, "imu.reason = 'no_idea'");
}

/// What a step leaves, of a camera of 16x2.
struct StepTakerTest : testing::Test {
  static constexpr ImageSpec camera{Pixel::gray8, 0, 16, 2};
  BufferOutlet left{camera}, right{camera}, order{record_spec<DriveOrder>()}, truth{record_spec<Decision>()},
      drive{record_spec<DriveCommand>()};
  StepTaker taker{camera};
  TakenStep taken{camera};

  StepTakerTest() {
    for (BufferOutlet* outlet : {&left, &right}) std::fill_n(outlet->loan().row<uint8_t>(0), 2 * camera.stride(), uint8_t{outlet == &left});
    make_record<DriveOrder>(order.loan()).speed = 0.3;
    make_record<Decision>(truth.loan()).steering = Steering::turn_left;
    make_record<DriveCommand>(drive.loan()).speed = 0.2;
    taker.begin(taken);
    taker.see("camera/left", left.loan());
    taker.see("camera/right", right.loan());
  }
};

TEST_F(StepTakerTest, a_view_of_another_size_or_kind_is_no_part_of_a_pair) {
  EXPECT_TRUE(taken.step.has_pair());
  BufferOutlet wide(ImageSpec{Pixel::gray8, 0, 4096, 1}), deep(ImageSpec{Pixel::count16, 0, 16, 2});
  for (Outlet* other : {static_cast<Outlet*>(&wide), static_cast<Outlet*>(&deep)}) {
    for (const char* topic : {"camera/left", "camera/right"}) {
      std::fill_n(other->loan().row<uint8_t>(0), 64, uint8_t{9});
      taker.begin(taken);
      taker.see("camera/left", left.loan());
      taker.see("camera/right", right.loan());
      taker.see(topic, other->loan());
      EXPECT_EQ(taken.step.reason, Reason::bad_pair) << topic;
      EXPECT_EQ(taken.views.left[0], 1) << "nothing of it was copied";
    }
  }
}

TEST_F(StepTakerTest, a_label_without_its_zero_is_read_to_its_end_and_not_beyond) {
  Events& events = taken.step.event.record;
  events.count = Events::capacity;
  std::fill(std::begin(events.entries[7].label), std::end(events.entries[7].label), 'L');
  events.tally.accepted = 0x4c4c4c4c4c4c4c4c;
  EXPECT_EQ(events.entries[7].text(), std::string(48, 'L'));
  EXPECT_EQ(events.entries[0].text(), "");
  const std::string line = recording::step_line(taken.step, true);
  EXPECT_NE(line.find("\"" + std::string(48, 'L') + "\""), std::string::npos);
}

TEST_F(StepTakerTest, the_label_is_the_simulators_before_the_operators) {
  taker.see("in/drive", order.loan());
  taker.see("truth/steering", truth.loan());
  ASSERT_TRUE(taker.finish());
  EXPECT_EQ(taken.views.label, Label::left);
  EXPECT_EQ(taken.views.left[0], 1);
  EXPECT_EQ(taken.views.right[camera.stride()], 0);
}

TEST_F(StepTakerTest, an_order_labels_while_it_is_younger_than_300_ms) {
  for (const double age : {0.1, 0.29, 0.31}) {
    order.loan().row<DriveOrder>(0)->age_s = age;
    taker.begin(taken);
    taker.see("camera/left", left.loan());
    taker.see("in/drive", order.loan());
    ASSERT_TRUE(taker.finish());
    EXPECT_EQ(taken.views.label, age < 0.3 ? Label::forward : Label::none);
    EXPECT_EQ(std::isnan(taken.views.speed), age > 0.3);
  }
}

TEST_F(StepTakerTest, speed_is_what_the_rover_was_told_in_the_end_and_the_decision_is_no_label) {
  taker.see("in/drive", order.loan());
  taker.see("drive", drive.loan());
  taker.see("decision", truth.loan());
  ASSERT_TRUE(taker.finish());
  EXPECT_EQ(taken.views.speed, 0.2);
  EXPECT_EQ(taken.views.label, Label::forward);
}

TEST_F(StepTakerTest, a_blind_order_labels_nothing_and_its_record_is_kept) {
  order.loan().set_blind(Reason::no_drive);
  taker.see("in/drive", order.loan());
  ASSERT_TRUE(taker.finish());
  EXPECT_EQ(taken.views.label, Label::none);
  EXPECT_EQ(taken.step.drive.reason, Reason::no_drive);
  EXPECT_EQ(taken.step.drive.record.speed, 0.3);
  EXPECT_FALSE(taker.finish()) << "nothing came of a next step";
}

TEST(Label, is_what_the_order_turns_to) {
  EXPECT_EQ(label_of(0.3, 0), Label::forward);
  EXPECT_EQ(label_of(0.3, 0.05), Label::forward);
  EXPECT_EQ(label_of(0, 0.5), Label::left);
  EXPECT_EQ(label_of(0.3, -0.5), Label::right);
  EXPECT_EQ(label_of(0, 0), Label::none);
  EXPECT_EQ(label_of(Steering::turn_left), Label::left);
}

}  // namespace
}  // namespace vdisp
