// v4l2_test.cpp: the V4L2 driver against devices that behave, misbehave and go away; the kernel's answers are the test's.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sources/v4l2.h"

#include <gtest/gtest.h>
#include <linux/videodev2.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <deque>
#include <map>
#include <mutex>
#include <opencv2/imgcodecs.hpp>
#include <thread>

#include "tests/support/live_steps.h"

namespace vdisp {
namespace {

/// One device as the kernel shows it.
struct Device {
  std::string card = "Test camera", bus = "usb-1";
  std::vector<uint32_t> formats{V4L2_PIX_FMT_YUYV};
  uint32_t width = 64, height = 48;
  int open_error = 0, stream_error = 0;
  bool there = true, adjusts_size = false, has_exposure = true;
  uint32_t frame_flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
  int exposure = -1, automatic = -1, gain = -1;
  std::vector<uint8_t> bytes;  ///< of each frame; empty: the number of the frame in each byte
  v4l2_fract period{1, 100};
};

/// A kernel with these devices, each delivering a frame every 10 ms.
class TestKernel final : public V4l2System {
 public:
  std::map<std::string, Device> devices_;

  std::vector<std::string> devices() override {
    std::vector<std::string> names;
    for (const auto& [name, device] : devices_)
      if (device.there) names.push_back(name);
    return names;
  }
  int open(const char* path) override {
    const std::lock_guard lock(mutex_);
    const auto found = devices_.find(path);
    if (found == devices_.end() || !found->second.there) return errno = ENOENT, -1;
    if (found->second.open_error) return errno = found->second.open_error, -1;
    files_[++last_file_] = {&found->second, {}, {}, 0, 0};
    return last_file_;
  }
  int close(int file) override {
    const std::lock_guard lock(mutex_);
    files_.erase(file);
    return 0;
  }
  int control(int file, unsigned long request, void* argument) override {
    const std::lock_guard lock(mutex_);
    File& f = files_.at(file);
    Device& device = *f.device;
    if (!device.there) return errno = ENODEV, -1;
    switch (request) {
      case VIDIOC_QUERYCAP: {
        auto& c = *static_cast<v4l2_capability*>(argument);
        std::strcpy(reinterpret_cast<char*>(c.card), device.card.c_str());
        std::strcpy(reinterpret_cast<char*>(c.bus_info), device.bus.c_str());
        c.capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
        return 0;
      }
      case VIDIOC_ENUM_FMT: {
        auto& d = *static_cast<v4l2_fmtdesc*>(argument);
        if (d.index >= device.formats.size()) return errno = EINVAL, -1;
        d.pixelformat = device.formats[d.index];
        return 0;
      }
      case VIDIOC_ENUM_FRAMESIZES: {
        auto& s = *static_cast<v4l2_frmsizeenum*>(argument);
        if (s.index > 0) return errno = EINVAL, -1;
        s.type = V4L2_FRMSIZE_TYPE_DISCRETE;
        s.discrete = {device.width, device.height};
        return 0;
      }
      case VIDIOC_G_FMT:
      case VIDIOC_S_FMT: {
        v4l2_pix_format& pix = static_cast<v4l2_format*>(argument)->fmt.pix;
        if (request == VIDIOC_G_FMT || device.adjusts_size) pix.width = device.width, pix.height = device.height;
        const bool two = pix.pixelformat == V4L2_PIX_FMT_YUYV || pix.pixelformat == V4L2_PIX_FMT_UYVY;
        pix.bytesperline = pix.pixelformat == V4L2_PIX_FMT_MJPEG ? 0 : pix.width * (two ? 2 : 1);
        f.size = pix.width * pix.height * 2;
        return 0;
      }
      case VIDIOC_G_PARM: return static_cast<v4l2_streamparm*>(argument)->parm.capture.timeperframe = device.period, 0;
      case VIDIOC_S_PARM: return device.period = static_cast<v4l2_streamparm*>(argument)->parm.capture.timeperframe, 0;
      case VIDIOC_QUERYCTRL: {
        auto& q = *static_cast<v4l2_queryctrl*>(argument);
        if (!device.has_exposure) return errno = EINVAL, -1;
        q.minimum = 1;
        q.maximum = q.id == V4L2_CID_GAIN ? 101 : 500;
        return 0;
      }
      case VIDIOC_S_CTRL: {
        const auto& c = *static_cast<v4l2_control*>(argument);
        if (!device.has_exposure) return errno = EINVAL, -1;
        if (c.id == V4L2_CID_EXPOSURE_ABSOLUTE) device.exposure = c.value;
        if (c.id == V4L2_CID_EXPOSURE_AUTO) device.automatic = c.value;
        if (c.id == V4L2_CID_GAIN) device.gain = c.value;
        return 0;
      }
      case VIDIOC_REQBUFS: return 0;
      case VIDIOC_QUERYBUF: {
        auto& b = *static_cast<v4l2_buffer*>(argument);
        b.length = f.size;
        b.m.offset = b.index;
        return 0;
      }
      case VIDIOC_QBUF: return f.queued.push_back(static_cast<v4l2_buffer*>(argument)->index), 0;
      case VIDIOC_DQBUF: return fill(f, *static_cast<v4l2_buffer*>(argument));
      case VIDIOC_STREAMON: return device.stream_error ? (errno = device.stream_error, -1) : 0;
      case VIDIOC_STREAMOFF: return 0;
      default: return errno = ENOTTY, -1;
    }
  }
  void* map(int file, size_t bytes, long offset) override {
    const std::lock_guard lock(mutex_);
    auto& memory = files_.at(file).memory;
    if (memory.size() <= static_cast<size_t>(offset)) memory.resize(static_cast<size_t>(offset) + 1);
    memory[static_cast<size_t>(offset)].assign(bytes, 0);
    ++mapped_;
    return memory[static_cast<size_t>(offset)].data();
  }
  void unmap(void*, size_t) override { --mapped_; }
  int wait(int file, int timeout_ms) override {
    const int64_t end = monotonic_ns() + timeout_ms * 1'000'000LL;
    while (monotonic_ns() < end) {
      {
        const std::lock_guard lock(mutex_);
        File& f = files_.at(file);
        if (!f.device->there) return -1;
        if (monotonic_ns() / 10'000'000 > f.taken && !f.queued.empty()) return 1;
      }
      std::this_thread::sleep_for(std::chrono::microseconds(300));
    }
    return 0;
  }
  void set(const std::string& name, bool there) {
    const std::lock_guard lock(mutex_);
    devices_.at(name).there = there;
  }
  int files() {
    const std::lock_guard lock(mutex_);
    return static_cast<int>(files_.size());
  }
  int mapped() const { return mapped_; }

 private:
  struct File {
    Device* device;
    std::deque<uint32_t> queued;
    std::vector<std::vector<uint8_t>> memory;
    uint32_t size;
    int64_t taken;
  };
  static int fill(File& f, v4l2_buffer& buffer) {
    if (f.queued.empty()) return errno = EAGAIN, -1;
    f.taken = monotonic_ns() / 10'000'000;
    buffer.index = f.queued.front();
    f.queued.pop_front();
    buffer.flags = f.device->frame_flags;
    buffer.sequence = static_cast<uint32_t>(f.taken);
    buffer.timestamp = {f.taken / 100, f.taken % 100 * 10'000};
    auto& memory = f.memory[buffer.index];
    const auto& bytes = f.device->bytes;
    if (bytes.empty()) {
      std::fill(memory.begin(), memory.end(), static_cast<uint8_t>(f.taken));
      buffer.bytesused = f.size;
    } else {
      std::copy_n(bytes.begin(), std::min(bytes.size(), memory.size()), memory.begin());
      buffer.bytesused = static_cast<uint32_t>(bytes.size());
    }
    return 0;
  }

  std::mutex mutex_;
  std::map<int, File> files_;
  int last_file_ = 100;
  std::atomic<int> mapped_{0};
};

class V4l2 : public LiveSteps {
 protected:
  V4l2() {
    kernel_.devices_["/dev/video0"] = {};
    kernel_.devices_["/dev/video2"] = {};
    kernel_.devices_["/dev/video2"].bus = "usb-2";
  }
  ~V4l2() override { source_.reset(); }  // its threads ask the kernel
  void start() { open(open_live(config_, v4l2_cameras(config_, kernel_))); }
  std::string refusal(int code) {
    return refusal_of(code, [&] { start(); });
  }

  TestKernel kernel_;
};

TEST_F(V4l2, two_cameras_attached_are_a_pair_of_one_moment) {
  start();
  for (int i = 0; i < 20; ++i) {
    ASSERT_EQ(step(), Outcome::valid) << source_->fault();
    EXPECT_EQ(images_[0]->row<uint8_t>(3)[5], images_[1]->row<uint8_t>(3)[5]);
    EXPECT_EQ(images_[0]->timestamp_ns / 10'000'000 & 255, images_[0]->row<uint8_t>(3)[5]);
  }
  source_.reset();
  EXPECT_EQ(kernel_.files(), 0);
  EXPECT_EQ(kernel_.mapped(), 0);
}

TEST_F(V4l2, one_camera_gives_both_views_side_by_side) {
  kernel_.devices_.erase("/dev/video2");
  Device& device = kernel_.devices_["/dev/video0"];
  device.formats = {V4L2_PIX_FMT_GREY};
  device.width = 128;
  for (int y = 0; y < 48; ++y) device.bytes.insert(device.bytes.end(), 64, 10), device.bytes.insert(device.bytes.end(), 64, 20);
  config_.camera.views = "beside";
  start();
  ASSERT_EQ(step(), Outcome::valid) << source_->fault();
  EXPECT_EQ(images_[0]->spec.width, 64);
  EXPECT_EQ(images_[0]->row<uint8_t>(47)[63], 10);
  EXPECT_EQ(images_[1]->row<uint8_t>(47)[0], 20);
}

TEST_F(V4l2, a_damaged_jpeg_is_no_frame) {
  cv::Mat picture(48, 64, CV_8U, cv::Scalar(99));
  std::vector<uint8_t> jpeg;
  cv::imencode(".jpg", picture, jpeg);
  for (auto& [name, device] : kernel_.devices_) device.formats = {V4L2_PIX_FMT_MJPEG}, device.bytes = jpeg;
  start();
  ASSERT_EQ(step(), Outcome::valid) << source_->fault();
  EXPECT_NEAR(images_[0]->row<uint8_t>(20)[20], 99, 2);
  source_.reset(), outlets_.clear(), images_.clear();
  jpeg.resize(jpeg.size() / 2);
  for (auto& [name, device] : kernel_.devices_) device.bytes = jpeg;
  start();
  ASSERT_EQ(step(), Outcome::invalid);
  EXPECT_EQ(images_[0]->reason, Reason::bad_frames);
  EXPECT_NE(source_->fault().find("JPEG"), std::string_view::npos) << source_->fault();
}

TEST_F(V4l2, a_camera_comes_back_under_another_number_and_no_other_takes_its_place) {
  config_.camera.left = "/dev/video0";
  config_.camera.right = "/dev/video2";
  start();
  ASSERT_EQ(step(), Outcome::valid);
  kernel_.set("/dev/video2", false);
  ASSERT_TRUE(until(Outcome::invalid));
  EXPECT_EQ(images_[0]->reason, Reason::no_camera);
  // Another camera under the same name is not taken.
  kernel_.devices_["/dev/video2"].card = "Another";
  kernel_.set("/dev/video2", true);
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));
  EXPECT_EQ(step(), Outcome::invalid);
  Device same = kernel_.devices_["/dev/video0"];
  same.bus = "usb-2";
  kernel_.devices_["/dev/video5"] = same;
  EXPECT_TRUE(until(Outcome::valid));
}

TEST_F(V4l2, incomplete_frames_are_counted_and_never_used) {
  kernel_.devices_["/dev/video0"].frame_flags |= V4L2_BUF_FLAG_ERROR;
  start();
  ASSERT_EQ(step(), Outcome::invalid);
  EXPECT_EQ(images_[0]->reason, Reason::bad_frames);
  step();
  EXPECT_GT(source_->cameras()->view[0].incomplete, 0u);
  EXPECT_EQ(source_->cameras()->pairs, 0u);
}

TEST_F(V4l2, a_frame_that_is_too_short_is_said_with_both_sizes) {
  kernel_.devices_["/dev/video0"].bytes.assign(100, 0);
  start();
  ASSERT_EQ(step(), Outcome::invalid);
  EXPECT_NE(source_->fault().find("100 bytes, needed are 6144"), std::string_view::npos) << source_->fault();
}

TEST_F(V4l2, exposure_and_gain_are_set_in_the_units_of_the_kernel) {
  config_.camera.exposeBy = "fixed";
  config_.camera.exposure = 5000;
  config_.camera.gain = 12;
  start();
  EXPECT_EQ(kernel_.devices_["/dev/video0"].exposure, 50);
  EXPECT_EQ(kernel_.devices_["/dev/video0"].automatic, V4L2_EXPOSURE_MANUAL);
  EXPECT_EQ(kernel_.devices_["/dev/video0"].gain, 51);
}

TEST_F(V4l2, the_rate_is_asked_for) {
  config_.image_source.rate = 15;
  start();
  EXPECT_EQ(kernel_.devices_["/dev/video0"].period.denominator, 15000u);
}

TEST_F(V4l2, what_cannot_be_had_is_refused_with_what_can) {
  EXPECT_NE((config_.camera.pixels = "gray16", refusal(78)).find("it has YUYV"), std::string::npos);
  config_.camera.pixels = "auto";
  config_.image_source.width = 640;
  for (auto& [name, device] : kernel_.devices_) device.adjusts_size = true;
  EXPECT_NE(refusal(78).find("it has 64x48"), std::string::npos);
  config_.image_source.width = 0;
  config_.camera.trigger = "line";
  EXPECT_NE(refusal(78).find("needed is free"), std::string::npos);
  config_.camera.trigger = "free";
  config_.camera.exposeBy = "floor";
  for (auto& [name, device] : kernel_.devices_) device.has_exposure = false;
  EXPECT_NE(refusal(78).find("exposeBy must be camera"), std::string::npos);
}

TEST_F(V4l2, no_permission_names_the_group) {
  config_.camera.left = "/dev/video0";
  config_.camera.right = "/dev/video2";
  kernel_.devices_["/dev/video0"].open_error = EACCES;
  EXPECT_NE(refusal(77).find("group of the device, which is video"), std::string::npos);
  config_.camera.left = config_.camera.right = "";
  EXPECT_NE(refusal(77).find("no permission for /dev/video0; the user"), std::string::npos);
}

TEST_F(V4l2, too_few_cameras_are_listed) {
  kernel_.devices_.erase("/dev/video2");
  const std::string line = refusal(69);
  EXPECT_NE(line.find("2 cameras are needed, there is /dev/video0 (Test camera, usb-1)"), std::string::npos) << line;
}

TEST_F(V4l2, a_named_camera_that_is_absent_or_in_use_or_starved_is_waited_for_and_says_why) {
  config_.camera.left = "/dev/video0";
  config_.camera.right = "/dev/video9";
  config_.image_source.width = 64;
  config_.image_source.height = 48;
  start();
  ASSERT_EQ(step(), Outcome::invalid);
  EXPECT_NE(source_->fault().find("there is /dev/video0 (Test camera, usb-1), /dev/video2"), std::string_view::npos) << source_->fault();
  source_.reset(), outlets_.clear(), images_.clear();
  config_.camera.right = "/dev/video2";
  kernel_.devices_["/dev/video2"].open_error = EBUSY;
  start();
  ASSERT_EQ(step(), Outcome::invalid);
  EXPECT_NE(source_->fault().find("another program uses it"), std::string_view::npos);
  source_.reset(), outlets_.clear(), images_.clear();
  kernel_.devices_["/dev/video2"].open_error = 0;
  kernel_.devices_["/dev/video2"].stream_error = ENOSPC;
  start();
  ASSERT_EQ(step(), Outcome::invalid);
  EXPECT_NE(source_->fault().find("USB bandwidth"), std::string_view::npos);
}

}  // namespace
}  // namespace vdisp
