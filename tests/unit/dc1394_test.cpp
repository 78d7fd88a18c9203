// dc1394_test.cpp: the FireWire driver against the stand-in for libdc1394; nothing here has met the hardware.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sources/dc1394.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "tests/support/live_steps.h"

namespace vdisp {
namespace {

class FireWire : public LiveSteps {
 protected:
  FireWire() {
    gone_ = testing::TempDir() + "/vdisp-gone-" + std::to_string(getpid());
    setenv("VDISP_STANDIN_GONE", gone_.c_str(), 1);
    setenv("VDISP_STANDIN_SIM", VDISP_SIM_MODULE, 1);
  }
  ~FireWire() override { std::filesystem::remove(gone_); }
  void start(const char* words) {
    setenv("VDISP_STANDIN", words, 1);
    open(open_live(config_, dc1394_cameras(config_)));
  }
  std::string refusal(const char* words, int code) {
    return refusal_of(code, [&] { start(words); });
  }
  /// Of a row through the scene: how far left the right view's best match is, px.
  int shift() const {
    const int v = 400;
    int best = 0, least = INT32_MAX;
    for (int d = -60; d <= 60; ++d) {
      int sum = 0;
      for (int u = 100; u < 540; ++u) sum += std::abs(images_[0]->row<uint8_t>(v)[u] - images_[1]->row<uint8_t>(v)[u - d]);
      if (sum < least) least = sum, best = d;
    }
    return best;
  }

  std::string gone_;
};

TEST_F(FireWire, an_mdcs2_gives_both_views_by_turns) {
  config_.camera.views = "turns";
  start("mdcs2");
  ASSERT_TRUE(until(Outcome::valid)) << source_->fault();
  EXPECT_EQ(images_[0]->spec.width, 640);
  EXPECT_GT(shift(), 5);
}

TEST_F(FireWire, the_order_of_its_bytes_is_found_either_way) {
  config_.camera.views = "turns";
  config_.camera.swap = "auto";
  for (const char* words : {"mdcs2", "mdcs2,right-first"}) {
    start(words);
    ASSERT_TRUE(until(Outcome::valid)) << source_->fault();
    ASSERT_TRUE(until(Outcome::valid));
    EXPECT_GT(shift(), 5) << words;
    EXPECT_EQ(source_->cameras()->exchanged, std::string(words) == "mdcs2" ? 0u : 1u);
    source_.reset();
  }
}

TEST_F(FireWire, swap_exchanges_the_views) {
  config_.camera.views = "turns";
  config_.camera.swap = "yes";
  start("mdcs2");
  ASSERT_TRUE(until(Outcome::valid)) << source_->fault();
  EXPECT_LT(shift(), -5);
}

TEST_F(FireWire, two_cameras_are_a_pair_of_one_moment) {
  start("pair");
  for (int i = 0; i < 5; ++i) {
    ASSERT_TRUE(until(Outcome::valid)) << source_->fault();
    EXPECT_GT(shift(), 5);
    EXPECT_LT(std::abs(source_->cameras()->apart_ms), 3);
  }
}

TEST_F(FireWire, the_calibration_comes_from_the_memory_of_the_camera) {
  config_.camera.views = "turns";
  start("mdcs2,calibration");
  ASSERT_TRUE(source_->calibration());
  EXPECT_NEAR(source_->calibration()->view.baseline, 0.09, 0.05);
  EXPECT_EQ(source_->calibration()->format, "SVS 4.0");
}

TEST_F(FireWire, a_colour_head_wants_its_mosaic_told) {
  config_.camera.views = "turns";
  EXPECT_NE(refusal("mdcs2,colour", 78).find("[image source] bayer must say its mosaic"), std::string::npos);
  config_.image_source.bayer = "grbg";
  EXPECT_NE(refusal("mdcs2", 78).find("bayer must be none"), std::string::npos);
  start("mdcs2,colour");
  EXPECT_TRUE(until(Outcome::valid)) << source_->fault();
}

TEST_F(FireWire, an_unplugged_camera_is_waited_for) {
  config_.camera.views = "turns";
  start("mdcs2");
  ASSERT_TRUE(until(Outcome::valid)) << source_->fault();
  std::ofstream(gone_) << "";
  ASSERT_TRUE(until(Outcome::invalid));
  EXPECT_EQ(images_[0]->reason, Reason::no_camera);
  std::filesystem::remove(gone_);
  EXPECT_TRUE(until(Outcome::valid));
}

TEST_F(FireWire, incomplete_frames_are_counted_and_left_out) {
  config_.camera.views = "turns";
  start("mdcs2,corrupt");
  for (int i = 0; i < 12; ++i) step();
  EXPECT_GT(source_->cameras()->view[0].incomplete, 1u);
}

TEST_F(FireWire, a_wall_clock_that_is_stepped_moves_no_frame_in_time) {
  config_.camera.views = "turns";
  start("mdcs2,stepped");
  for (int i = 0; i < 9; ++i) {
    ASSERT_TRUE(until(Outcome::valid)) << source_->fault();
    EXPECT_NEAR(static_cast<double>(monotonic_ns() - images_[0]->timestamp_ns) * 1e-9, 0, 1) << i;
  }
}

TEST_F(FireWire, software_triggers_start_exposures) {
  config_.camera.trigger = "software";
  config_.image_source.rate = 5;
  config_.camera.tolerance = 100;
  start("pair");
  ASSERT_TRUE(until(Outcome::valid));
  const uint64_t before = source_->cameras()->pairs;
  const int64_t begin = monotonic_ns();
  while (monotonic_ns() - begin < 2'000'000'000) step();
  // Untriggered there would be 60. On a busy machine a trigger may come late, and then there are fewer.
  const uint64_t pairs = source_->cameras()->pairs - before;
  EXPECT_GE(pairs, 4u);
  EXPECT_LE(pairs, 12u);
}

TEST_F(FireWire, exposure_and_gain_are_set) {
  config_.camera.views = "turns";
  config_.camera.exposeBy = "fixed";
  config_.camera.exposure = 2500;
  start("mdcs2");
  ASSERT_TRUE(until(Outcome::valid)) << source_->fault();
  const double half = source_->cameras()->view[0].floor_level;
  source_.reset();
  config_.camera.gain = 6.02;
  start("mdcs2");
  ASSERT_TRUE(until(Outcome::valid)) << source_->fault();
  EXPECT_NEAR(source_->cameras()->view[0].floor_level / half, 2, 0.1);
}

TEST_F(FireWire, what_cannot_be_had_is_refused_with_what_can) {
  config_.camera.views = "turns";
  config_.image_source.width = 800;
  config_.image_source.height = 600;
  EXPECT_NE(refusal("mdcs2", 78).find("it has 320x240, 640x480, 1280x960"), std::string::npos);
  config_.image_source.width = config_.image_source.height = 0;
  config_.camera.trigger = "line";
  EXPECT_NE(refusal("mdcs2,untrigger", 78).find("needed is free"), std::string::npos);
  config_.camera.trigger = "free";
  EXPECT_NE(refusal("", 69).find("on the bus there is none"), std::string::npos);
  config_.camera.left = "LEFT01";
  EXPECT_NE(refusal("mdcs2", 78).find("16 hexadecimal digits"), std::string::npos);
  config_.camera.left = "1";
  config_.camera.views = "turns";
  start("mdcs2");
  ASSERT_EQ(step(), Outcome::invalid);
  EXPECT_NE(source_->fault().find("there is 0055050000000001"), std::string_view::npos) << source_->fault();
  source_.reset();
  config_.camera.left.clear();
  start("mdcs2,full");
  ASSERT_EQ(step(), Outcome::invalid);
  EXPECT_NE(source_->fault().find("no bandwidth"), std::string_view::npos) << source_->fault();
}

}  // namespace
}  // namespace vdisp
