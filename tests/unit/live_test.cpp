// live_test.cpp: the source behind all camera drivers, with cameras that do what a test tells them.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sources/live.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstring>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <thread>
#include <vector>

#include "daemon/sources/exposure.h"
#include "daemon/sources/raw_pixels.h"
#include "daemon/sources/view_order.h"
#include "tests/support/live_steps.h"

namespace vdisp {
namespace {

using namespace std::chrono_literals;
constexpr int width = 64, height = 48;
constexpr int64_t period_ns = 10'000'000;

/// What the test says to a camera while it runs.
struct Orders {
  std::atomic<bool> there{true}, gone{false}, incomplete{false}, silent{false};
  std::atomic<int> opened{0}, width{vdisp::width};
  std::atomic<int64_t> late_ns{0};
  std::atomic<double> exposure{0};
  CameraFault fault = CameraFault::absent;
};

/// Delivers a frame each period of the one clock, its number in each pixel.
class ToldCamera final : public Camera {
 public:
  ToldCamera(std::string name, Orders& orders) : name_(std::move(name)), orders_(orders) {}
  const std::string& name() const override { return name_; }
  FrameFormat open() override {
    if (!orders_.there) throw CameraError(orders_.fault, name_ + " is not there");
    ++orders_.opened;
    next_ = monotonic_ns() / period_ns + 1;
    pixels_.assign(static_cast<size_t>(orders_.width) * height, std::byte{0});
    return {FramePixels::gray8, FrameViews::one, orders_.width, height, orders_.width, "", 0.01};
  }
  Delivery wait(int timeout_ms, RawFrame& frame) noexcept override {
    if (orders_.gone) return Delivery::lost;
    if (orders_.silent) return std::this_thread::sleep_for(std::chrono::milliseconds(timeout_ms)), Delivery::nothing;
    while (monotonic_ns() < next_ * period_ns + orders_.late_ns) std::this_thread::sleep_for(200us);
    std::fill(pixels_.begin(), pixels_.end(), static_cast<std::byte>(next_ & 255));
    frame.bytes = pixels_.data();
    frame.size = pixels_.size();
    frame.arrival_ns = monotonic_ns();
    frame.exposed_ns = next_ * period_ns + orders_.late_ns;
    frame.count = static_cast<uint64_t>(next_++);
    return orders_.incomplete ? Delivery::incomplete : Delivery::frame;
  }
  void release(const RawFrame&) noexcept override {}
  void close() noexcept override {}
  std::string_view problem() const noexcept override { return orders_.gone ? "unplugged" : "half a frame"; }
  bool expose(double exposure, double) noexcept override { return orders_.exposure = exposure, true; }

 private:
  std::string name_;
  Orders& orders_;
  int64_t next_ = 0;
  std::vector<std::byte> pixels_;
};

class Live : public LiveSteps {
 protected:
  void start() {
    std::vector<std::unique_ptr<Camera>> cameras;
    cameras.push_back(std::make_unique<ToldCamera>("left camera", orders_[0]));
    cameras.push_back(std::make_unique<ToldCamera>("right camera", orders_[1]));
    open(open_live(config_, std::move(cameras)));
  }

  Orders orders_[2];
};

TEST_F(Live, gives_out_pairs_of_one_exposure_in_order) {
  start();
  int64_t last = 0;
  for (int i = 0; i < 50; ++i) {
    ASSERT_EQ(step(), Outcome::valid) << source_->fault();
    EXPECT_EQ(images_[0]->row<uint8_t>(5)[7], images_[1]->row<uint8_t>(5)[7]);
    EXPECT_EQ(images_[0]->timestamp_ns, images_[1]->timestamp_ns);
    EXPECT_GT(images_[0]->timestamp_ns, last);
    last = images_[0]->timestamp_ns;
  }
  EXPECT_EQ(source_->cameras()->view[0].unpaired + source_->cameras()->view[1].unpaired, 0u);
}

TEST_F(Live, is_blind_with_the_reason_while_a_camera_is_gone_and_sees_again_after) {
  start();
  ASSERT_EQ(step(), Outcome::valid);
  orders_[1].there = false;
  orders_[1].gone = true;
  ASSERT_TRUE(until(Outcome::invalid));
  EXPECT_EQ(images_[0]->reason, Reason::no_camera);
  EXPECT_NE(source_->fault().find("right camera"), std::string_view::npos) << source_->fault();
  orders_[1].gone = false;
  orders_[1].there = true;
  const int64_t back = monotonic_ns();
  ASSERT_TRUE(until(Outcome::valid));
  EXPECT_LT(monotonic_ns() - back, 2'000'000'000);
  EXPECT_EQ(source_->cameras()->view[1].opened, 2u);
  EXPECT_EQ(source_->cameras()->view[0].opened, 1u);
}

TEST_F(Live, starts_without_a_camera_and_waits_for_it) {
  orders_[0].there = false;
  config_.image_source.width = width;
  config_.image_source.height = height;
  start();
  ASSERT_EQ(step(), Outcome::invalid);
  EXPECT_EQ(images_[0]->reason, Reason::no_camera);
  EXPECT_EQ(source_->fault(), "left camera is not there");
  orders_[0].there = true;
  EXPECT_TRUE(until(Outcome::valid));
}

TEST_F(Live, does_not_start_where_waiting_does_not_help) {
  orders_[0].there = false;
  orders_[0].fault = CameraFault::denied;
  try {
    start();
    FAIL();
  } catch (const SourceError& error) {
    EXPECT_EQ(error.exit_code, 77);
  }
}

TEST_F(Live, refuses_cameras_of_two_sizes) {
  orders_[1].width = 32;
  try {
    start();
    FAIL();
  } catch (const SourceError& error) {
    EXPECT_EQ(error.exit_code, 78);
    EXPECT_NE(std::string(error.what()).find("32x48"), std::string::npos) << error.what();
  }
}

TEST_F(Live, processes_no_incomplete_frame) {
  start();
  orders_[0].incomplete = true;
  ASSERT_TRUE(until(Outcome::invalid));
  EXPECT_EQ(images_[0]->reason, Reason::bad_frames);
  EXPECT_NE(source_->fault().find("half a frame"), std::string_view::npos);
  EXPECT_GT(source_->cameras()->view[0].incomplete, 0u);
}

TEST_F(Live, says_that_cameras_run_apart) {
  config_.camera.tolerance = 1;
  orders_[1].late_ns = 4'000'000;
  start();
  ASSERT_EQ(step(), Outcome::invalid);
  ASSERT_EQ(step(), Outcome::invalid);
  EXPECT_EQ(images_[0]->reason, Reason::unpaired);
  EXPECT_NE(source_->fault().find("4.00 ms after"), std::string_view::npos) << source_->fault();
}

TEST_F(Live, opens_a_silent_camera_again) {
  start();
  orders_[0].silent = true;
  ASSERT_TRUE(until(Outcome::invalid));
  for (int i = 0; i < 60 && orders_[0].opened < 2; ++i) std::this_thread::sleep_for(100ms);
  EXPECT_GE(orders_[0].opened, 2);
}

TEST_F(Live, exposes_both_cameras_alike_for_the_floor) {
  config_.camera.exposeBy = "floor";
  config_.camera.exposure = 1000;
  start();
  for (int i = 0; i < 60; ++i) step();  // levels go from 0 to 255 and round again
  EXPECT_GT(orders_[0].exposure, 0);
  for (int i = 0; i < 20 && orders_[0].exposure != orders_[1].exposure; ++i) std::this_thread::sleep_for(20ms);
  EXPECT_EQ(orders_[0].exposure, orders_[1].exposure);
}

TEST(FloorExposure, comes_to_the_middle_from_dark_and_bright) {
  for (const double light : {0.002, 0.05, 3.0}) {  // level per us
    FloorExposure exposure({5000, 0}, 15000, 24);
    double level = 0;
    for (int i = 0; i < 60; ++i) {
      level = std::min(255.0, light * exposure.setting().exposure_us * std::pow(10, exposure.setting().gain_db / 20));
      exposure.see({level, 0, level > 250 ? 1.0 : 0.0});
    }
    EXPECT_NEAR(level, FloorExposure::wanted_level, FloorExposure::wanted_level * FloorExposure::tolerated) << light;
  }
}

TEST(FloorExposure, raises_gain_only_when_exposure_ends) {
  FloorExposure exposure({5000, 0}, 15000, 24);
  for (int i = 0; i < 60; ++i) {
    const double light = 0.002 * exposure.setting().exposure_us * std::pow(10, exposure.setting().gain_db / 20);
    exposure.see({light, 0, 0});
    if (exposure.setting().gain_db > 0) {
      EXPECT_DOUBLE_EQ(exposure.setting().exposure_us, 15000);
    }
  }
  EXPECT_GT(exposure.setting().gain_db, 0);
}

/// 4 x 2 pixels of each kind, the value of a pixel known by hand.
TEST(RawPixels, make_gray_of_every_kind) {
  struct Case {
    FramePixels pixels;
    std::vector<uint8_t> bytes;  // of one pixel, or of two for yuyv and uyvy
    uint8_t gray;
  };
  const std::vector<Case> cases{
      {FramePixels::gray8, {200}, 200},         {FramePixels::bayer8, {77}, 77},           {FramePixels::gray10, {0xff, 0x03}, 255},
      {FramePixels::gray12, {0x00, 0x08}, 128}, {FramePixels::gray16, {0x34, 0x12}, 0x12}, {FramePixels::rgb8, {255, 0, 0}, 77},
      {FramePixels::bgr8, {255, 0, 0}, 29},     {FramePixels::yuyv, {90, 1, 90, 2}, 90},   {FramePixels::uyvy, {1, 90, 2, 90}, 90}};
  for (const Case& c : cases) {
    FrameFormat format{c.pixels, FrameViews::one, 4, 2, 0, "", 0};
    std::vector<uint8_t> bytes;
    while (bytes.size() < 8u * static_cast<size_t>(raw_pixel_bytes(format))) bytes.insert(bytes.end(), c.bytes.begin(), c.bytes.end());
    format.stride = 4 * raw_pixel_bytes(format);
    std::vector<uint8_t> gray(8);
    const GrayView view{gray.data(), 4, 2, 4};
    RawFrame frame;
    frame.bytes = reinterpret_cast<const std::byte*>(bytes.data());
    frame.size = bytes.size();
    RawPixels pixels;
    ASSERT_TRUE(pixels.write(format, frame, false, {&view, 1})) << pixels.problem();
    for (const uint8_t value : gray) EXPECT_EQ(value, c.gray) << static_cast<int>(c.pixels);
    --frame.size;
    EXPECT_FALSE(pixels.write(format, frame, false, {&view, 1}));
  }
}

TEST(RawPixels, separate_views_beside_each_other_and_by_turns_either_way_round) {
  const std::vector<uint8_t> bytes{1, 2, 1, 2, 1, 2, 1, 2};
  for (const bool exchanged : {false, true}) {
    std::vector<uint8_t> gray(8);
    const GrayView views[] = {{gray.data(), 2, 2, 2}, {gray.data() + 4, 2, 2, 2}};
    RawFrame frame;
    frame.bytes = reinterpret_cast<const std::byte*>(bytes.data());
    frame.size = bytes.size();
    RawPixels pixels;
    ASSERT_TRUE(pixels.write({FramePixels::gray8, FrameViews::by_turns, 2, 2, 4, "", 0}, frame, exchanged, views));
    EXPECT_EQ(gray, exchanged ? (std::vector<uint8_t>{2, 2, 2, 2, 1, 1, 1, 1}) : (std::vector<uint8_t>{1, 1, 1, 1, 2, 2, 2, 2}));
    ASSERT_TRUE(pixels.write({FramePixels::gray8, FrameViews::beside, 2, 2, 4, "", 0}, frame, exchanged, views));
    EXPECT_EQ(gray, (std::vector<uint8_t>{1, 2, 1, 2, 1, 2, 1, 2}));
  }
}

TEST(RawPixels, refuse_damaged_jpegs_at_every_length) {
  cv::Mat picture(height, width, CV_8U);
  cv::randu(picture, 0, 255);
  std::vector<uint8_t> jpeg;
  ASSERT_TRUE(cv::imencode(".jpg", picture, jpeg));
  std::vector<uint8_t> gray(width * height);
  const GrayView view{gray.data(), width, height, width};
  const FrameFormat format{FramePixels::jpeg, FrameViews::one, width, height, 0, "", 0};
  RawPixels pixels;
  RawFrame frame;
  frame.bytes = reinterpret_cast<const std::byte*>(jpeg.data());
  frame.size = jpeg.size();
  ASSERT_TRUE(pixels.write(format, frame, false, {&view, 1})) << pixels.problem();
  for (size_t size = 0; size + 2 < jpeg.size(); size += 17) {
    frame.size = size;
    EXPECT_FALSE(pixels.write(format, frame, false, {&view, 1})) << size;
    EXPECT_FALSE(pixels.problem().empty());
  }
}

class Order : public testing::Test {
 protected:
  /// A view with random blobs, and one where all lies `shift` px farther left.
  void draw(int shift, uint16_t columns = 320) {
    const ImageSpec spec{Pixel::gray8, 0, columns, 240};
    cv::Mat world(240, 500, CV_8U), smooth;
    cv::theRNG().state = 7;
    cv::randu(world, 0, 255);
    cv::resize(world(cv::Rect(0, 0, 63, 30)), smooth, world.size(), 0, 0, 2);
    for (int i = 0; i < 2; ++i) {
      outlets_[i] = std::make_unique<BufferOutlet>(spec);
      views_[i] = &outlets_[i]->loan();
      for (int v = 0; v < 240; ++v) std::memcpy(views_[i]->row<uint8_t>(v), smooth.ptr(v) + 90 + (i == 1 ? shift : 0), columns);
    }
    order_.prepare(spec);
  }
  std::optional<bool> look() {
    std::optional<bool> found;
    for (int i = 0; i < 10 && !found; ++i) found = order_.see(*views_[0], *views_[1]);
    return found;
  }
  std::unique_ptr<BufferOutlet> outlets_[2];
  Image* views_[2];
  ViewOrder order_;
};

TEST_F(Order, is_told_by_what_is_near) {
  draw(20);
  ASSERT_TRUE(look());
  order_ = {};
  draw(20);
  EXPECT_TRUE(*look());
  order_ = {};
  draw(-20);
  EXPECT_FALSE(*look());
}

TEST_F(Order, is_told_of_small_views_too) {
  draw(12, 160);
  ASSERT_TRUE(look());
  order_ = {};
  draw(-12, 160);
  EXPECT_FALSE(*look());
}

TEST_F(Order, is_not_told_by_equal_views) {
  draw(0);
  EXPECT_FALSE(look());
}

}  // namespace
}  // namespace vdisp
