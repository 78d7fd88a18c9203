// aravis_test.cpp: which camera is meant, and Aravis' built-in fake camera through the driver. Real packets: tests/system/210-gige.py.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sources/aravis.h"

#include <arv.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "daemon/core/clock.h"
#include "daemon/sources/aravis_list.h"
#include "daemon/sources/frame_count.h"
#include "daemon/sources/gige_knock.h"
#include "daemon/sources/network_link.h"
#include "daemon/sources/raw_pixels.h"
#include "daemon/sources/usb_vision.h"

namespace vdisp {
namespace {

AttachedCamera camera(const std::string& serial, const std::string& address) {
  return {"Maker-M1-" + serial, "00:11:" + serial, address, "Maker", "M1", serial, true};
}

const std::vector<AttachedCamera> two{camera("A1", "10.0.0.1"), camera("B2", "10.0.0.2")};

std::string refusal(const CameraWish& wish, const std::vector<AttachedCamera>& attached) {
  try {
    return "chose " + choose(wish, attached).serial;
  } catch (const CameraError& error) {
    EXPECT_EQ(error.fault, CameraFault::absent);
    return error.what();
  }
}

TEST(Choose, knows_a_camera_by_serial_number_address_and_names) {
  for (const std::string name : {"B2", "10.0.0.2", "Maker-M1-B2", "Maker-B2", "00:11:B2"})
    EXPECT_EQ(choose({name, "", 0, 2}, two).serial, "B2") << name;
}

TEST(Choose, takes_what_is_attached_in_its_order_where_nothing_is_named) {
  EXPECT_EQ(choose({"", "", 0, 2}, two).serial, "A1");
  EXPECT_EQ(choose({"", "", 1, 2}, two).serial, "B2");
  EXPECT_EQ(choose({"", "B2", 1, 2}, two).serial, "A1");  // the one that the other side does not have
  EXPECT_EQ(choose({"", "", 0, 1}, {two[1]}).serial, "B2");
}

TEST(Choose, lists_what_there_is_where_it_is_not_what_is_meant) {
  EXPECT_EQ(refusal({"C3", "", 1, 2}, two),
            "[camera] right = C3: no such GigE Vision or USB3 Vision camera; found: GigE camera Maker-M1-A1 at 10.0.0.1, GigE camera "
            "Maker-M1-B2 at 10.0.0.2");
  EXPECT_NE(refusal({"", "", 0, 2}, {two[0]}).find("2 GigE Vision or USB3 Vision cameras are needed; found: GigE camera"),
            std::string::npos);
  EXPECT_NE(refusal({"", "", 0, 1}, two).find("name which"), std::string::npos);
  EXPECT_NE(refusal({"", "", 0, 2}, {}).find("found: none"), std::string::npos);
}

TEST(Choose, knows_the_same_hardware_wherever_it_is_plugged_in) {
  EXPECT_TRUE(camera("B2", "10.0.0.9").same_as(two[1]));
  EXPECT_FALSE(camera("C3", "10.0.0.2").same_as(two[1]));
  AttachedCamera usb = two[1];
  usb.gige = false;
  EXPECT_FALSE(usb.same_as(two[1]));
}

TEST(FrameCount, goes_on_where_16_bits_end_over_lost_frames_and_with_and_without_a_zero) {
  FrameCount count;
  const uint64_t first = count.of(65533);
  EXPECT_EQ(count.of(65535) - first, 2u);
  EXPECT_EQ(count.of(2) - first, 4u);
  FrameCount with_zero;
  const uint64_t start = with_zero.of(65534);
  EXPECT_EQ(with_zero.of(65535) - start, 1u);
  EXPECT_EQ(with_zero.of(0) - start, 2u);
  EXPECT_EQ(with_zero.of(1) - start, 3u);
  FrameCount wide;
  const uint64_t begin = wide.of(65535);
  EXPECT_EQ(wide.of(65536) - begin, 1u);
}

TEST(NetworkLink, refuses_what_does_not_fit_and_says_how_it_would) {
  const NetworkLink fast{"eth0", 1500, 1000};
  EXPECT_EQ(refuse_packets(fast, 1500), "");
  EXPECT_NE(refuse_packets(fast, 9000).find("ip link set eth0 mtu 9000"), std::string::npos);
  EXPECT_EQ(refuse_rate(fast, 640 * 480, 30), "");
  EXPECT_EQ(
      refuse_rate(fast, 2048 * 1536, 60),
      "frames of 3145728 bytes at 60 Hz need 1585 Mbit/s, eth0 has 1000; lower [image source] rate, width and height, or pixels of fewer "
      "bytes");
  EXPECT_EQ(refuse_rate({"lo", 65536, 0}, 2048 * 1536, 600), "");  // it does not tell
}

TEST(NetworkLink, is_that_of_the_address) {
  const NetworkLink link = network_link("127.0.0.1");
  EXPECT_EQ(link.name, "lo");
  EXPECT_GT(link.mtu, 1000);
  EXPECT_EQ(network_link("192.0.2.77").name, "");
}

TEST(Knock, waits_no_longer_than_it_says_where_nothing_answers) {
  const int64_t start = monotonic_ns();
  EXPECT_FALSE(knock_at_gige("127.0.0.77"));
  EXPECT_FALSE(knock_at_gige("no address"));
  EXPECT_LT(monotonic_ns() - start, 1'000'000'000);
}

TEST(UsbVision, names_a_camera_that_may_not_be_opened) {
  namespace fs = std::filesystem;
  const fs::path root = fs::path(testing::TempDir()) / ("usb" + std::to_string(getpid()));
  fs::create_directories(root / "sys/2-1:1.0");
  fs::create_directories(root / "sys/2-1");
  fs::create_directories(root / "dev/002");
  const auto write = [&](const std::string& name, const std::string& text) { std::ofstream(root / name) << text << "\n"; };
  write("sys/2-1/busnum", "2"), write("sys/2-1/devnum", "5"), write("sys/2-1/product", "Blackfly S");
  write("sys/2-1:1.0/bInterfaceClass", "ef"), write("sys/2-1:1.0/bInterfaceSubClass", "05"), write("sys/2-1:1.0/bInterfaceProtocol", "00");
  write("dev/002/005", "");
  const auto look = [&] { return unreadable_usb_cameras(root / "sys", root / "dev"); };
  EXPECT_EQ(look(), "");
  fs::permissions(root / "dev/002/005", fs::perms::none);
  const bool root_here = getuid() == 0;  // may open everything: then as nobody
  fs::permissions(root, fs::perms::others_all, fs::perm_options::add);
  ASSERT_EQ(root_here ? setresuid(65534, 65534, 0) : 0, 0);
  const std::string found = look();
  ASSERT_EQ(root_here ? setresuid(0, 0, 0) : 0, 0);
  EXPECT_NE(found.find("USB3 camera 'Blackfly S' is plugged in, and " + (root / "dev/002/005").string()), std::string::npos) << found;
  fs::remove_all(root);
}

/// One camera that gives both views: Aravis' own without a network.
class FakeCamera : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    arv_enable_interface("Fake");
    for (const char* interface : {"GigEVision", "USB3Vision"})
      arv_disable_interface(interface);  // what is attached here is nobody's business
  }
  void SetUp() override {
    config_.camera.views = "beside";
    config_.camera.left = "Fake_1";
    config_.camera.exposeBy = "fixed";
    config_.camera.exposure = 10000;
    config_.image_source.rate = 100;
    config_.image_source.width = 100;
    config_.image_source.height = 80;
  }
  void open() {
    camera_ = std::move(aravis_cameras(config_).front());
    format_ = camera_->open();
  }
  bool next() {
    for (int i = 0; i < 20; ++i)
      if (camera_->wait(200, frame_) == Delivery::frame) return true;
    return false;
  }
  Config config_;
  std::unique_ptr<Camera> camera_;
  FrameFormat format_;
  RawFrame frame_;
};

TEST_F(FakeCamera, gives_frames_of_the_format_it_says_one_after_the_other) {
  open();
  EXPECT_EQ(format_.width, 100);
  EXPECT_EQ(format_.height, 80);
  EXPECT_EQ(format_.stride, 200);
  EXPECT_NEAR(format_.period_s, 0.01, 1e-4);
  EXPECT_EQ(format_.exposure_us, 10000);
  uint64_t last = 0;
  for (int i = 0; i < 5; ++i) {
    ASSERT_TRUE(next());
    EXPECT_EQ(frame_.size, 200u * 80u);
    EXPECT_EQ(frame_.delay_ns, 5'000'000);  // half of the exposure
    const auto* pixels = reinterpret_cast<const uint8_t*>(frame_.bytes);
    EXPECT_EQ((pixels[0] + 1) % 255, pixels[1]);  // a ramp
    EXPECT_TRUE(last == 0 || frame_.count == last + 1) << last << ' ' << frame_.count;
    last = frame_.count;
    camera_->release(frame_);
  }
}

TEST_F(FakeCamera, opens_as_often_as_it_is_closed) {
  open();
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(next());
    camera_->close();
    camera_->open();
  }
  EXPECT_TRUE(next());
}

TEST_F(FakeCamera, is_exposed_within_its_bounds) {
  open();
  EXPECT_TRUE(camera_->expose(2000, 3));
  ASSERT_TRUE(next());
  EXPECT_EQ(frame_.delay_ns, 1'000'000);
  EXPECT_GE(camera_->longest_exposure(), 1e6);
  EXPECT_TRUE(camera_->expose(1e9, 100));
  // Frames on their way when it grew were exposed as before: of them only that is sure.
  for (int i = 0; i < 8; ++i) {
    ASSERT_TRUE(next());
    EXPECT_EQ(frame_.delay_ns, 2'000'000 - static_cast<int64_t>(camera_->longest_exposure() * 500));
  }
  ASSERT_TRUE(next());
  EXPECT_EQ(frame_.delay_ns, static_cast<int64_t>(camera_->longest_exposure() * 500));
}

TEST_F(FakeCamera, refuses_pixels_it_has_not_with_those_it_has) {
  config_.camera.pixels = "gray12";
  try {
    open();
    FAIL();
  } catch (const CameraError& error) {
    EXPECT_EQ(error.fault, CameraFault::unsupported);
    EXPECT_NE(std::string(error.what()).find("it has gray8, "), std::string::npos) << error.what();
  }
}

TEST_F(FakeCamera, survives_what_glib_would_die_of) {
  open();
  testing::internal::CaptureStderr();
  g_warning("not for the journal");
  g_critical("neither is this");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace vdisp
