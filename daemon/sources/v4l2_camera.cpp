// v4l2_camera.cpp: four buffers by mmap, given back as soon as they are read.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sources/v4l2_camera.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "daemon/core/clock.h"

namespace vdisp {
namespace {

constexpr uint32_t buffers_wanted = 4;

}  // namespace

V4l2Camera::V4l2Camera(V4l2System& system, std::string device, const Config& config)
    : system_(system), config_(config), device_(std::move(device)), name_("V4L2 camera " + device_) {}

void V4l2Camera::refuse(CameraFault fault, const std::string& what) {
  const std::string line = name_ + ": " + what;
  close();
  throw CameraError(fault, line);
}

void V4l2Camera::refuse_open(int error) {
  if (error == EACCES || error == EPERM)
    refuse(CameraFault::denied, "no permission; the user of vdispd must be in the group of the device, which is video on Debian");
  if (error == EBUSY) refuse(CameraFault::busy, "another program uses it");
  std::string there;
  for (const V4l2Device& device : find_v4l2(system_)) there += (there.empty() ? "" : ", ") + device.text();
  refuse(CameraFault::absent, "it is not there (" + std::system_category().message(error) + "); " +
                                  (there.empty() ? "there is no camera" : "there is " + there));
}

/// A camera that was unplugged may come back under another number: then it is looked for by what it is and where it is attached.
void V4l2Camera::open_device() {
  file_ = system_.open(device_.c_str());
  int error = errno;
  v4l2_capability capability{};
  const auto fits = [&] {
    return file_ >= 0 && system_.control(file_, VIDIOC_QUERYCAP, &capability) == 0 &&
           (bus_.empty() ||
            (bus_ == reinterpret_cast<const char*>(capability.bus_info) && card_ == reinterpret_cast<const char*>(capability.card)));
  };
  if (file_ < 0 && bus_.empty()) refuse_open(error);
  if (!fits() && !bus_.empty()) {
    for (const V4l2Device& device : find_v4l2(system_)) {
      if (device.bus != bus_ || device.card != card_) continue;
      if (file_ >= 0) system_.close(file_);
      file_ = system_.open(device.path.c_str());
      if (file_ < 0) error = errno;
      break;
    }
    if (file_ < 0) refuse_open(error);
    if (!fits())
      refuse(CameraFault::absent,
             "it is not there; in its place is another camera, " + std::string(reinterpret_cast<const char*>(capability.card)));
  }
  same_camera_only(capability);
}

void V4l2Camera::same_camera_only(const v4l2_capability& capability) {
  const uint32_t caps = capability.capabilities & V4L2_CAP_DEVICE_CAPS ? capability.device_caps : capability.capabilities;
  if (!(caps & V4L2_CAP_VIDEO_CAPTURE) || !(caps & V4L2_CAP_STREAMING))
    refuse(CameraFault::unsupported, "it is no camera that streams; needed are capture and streaming by mmap");
  card_ = reinterpret_cast<const char*>(capability.card);
  bus_ = reinterpret_cast<const char*>(capability.bus_info);
}

void V4l2Camera::start_stream() {
  v4l2_requestbuffers request{};
  request.count = buffers_wanted;
  request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  request.memory = V4L2_MEMORY_MMAP;
  if (system_.control(file_, VIDIOC_REQBUFS, &request) < 0)
    refuse(errno == EBUSY ? CameraFault::busy : CameraFault::failed,
           errno == EBUSY ? "another program uses it" : "VIDIOC_REQBUFS: " + std::system_category().message(errno));
  if (request.count < 2) refuse(CameraFault::failed, "the driver gives " + std::to_string(request.count) + " buffers, needed are 2");
  for (uint32_t i = 0; i < request.count; ++i) {
    v4l2_buffer buffer{};
    buffer.type = request.type;
    buffer.memory = request.memory;
    buffer.index = i;
    if (system_.control(file_, VIDIOC_QUERYBUF, &buffer) < 0)
      refuse(CameraFault::failed, "VIDIOC_QUERYBUF: " + std::system_category().message(errno));
    void* memory = system_.map(file_, buffer.length, static_cast<long>(buffer.m.offset));
    if (!memory) refuse(CameraFault::failed, "mmap: " + std::system_category().message(errno));
    buffers_.push_back({memory, buffer.length});
    if (system_.control(file_, VIDIOC_QBUF, &buffer) < 0)
      refuse(CameraFault::failed, "VIDIOC_QBUF: " + std::system_category().message(errno));
  }
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (system_.control(file_, VIDIOC_STREAMON, &type) < 0) {
    const int error = errno;
    refuse(error == EBUSY ? CameraFault::busy : CameraFault::failed,
           error == ENOSPC ? "there is not enough USB bandwidth; use [camera] pixels = jpeg, a lower rate or size, or a bus for each camera"
                           : "VIDIOC_STREAMON: " + std::system_category().message(error));
  }
  streaming_ = true;
}

FrameFormat V4l2Camera::open() {
  close();
  open_device();
  FrameFormat format;
  choose_format(format);
  set_rate(format);
  prepare_exposure();
  start_stream();
  return format;
}

/// The kernel stamps the first or the last byte; how long reading out takes it does not tell.
int64_t V4l2Camera::exposed_ns(const v4l2_buffer& buffer) const noexcept {
  if ((buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) != V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC) return -1;
  const int64_t stamp = buffer.timestamp.tv_sec * 1'000'000'000LL + buffer.timestamp.tv_usec * 1000LL;
  const auto half = static_cast<int64_t>(exposure_us_ * 500);
  return (buffer.flags & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) == V4L2_BUF_FLAG_TSTAMP_SRC_SOE ? stamp + half : stamp - half;
}

Delivery V4l2Camera::wait(int timeout_ms, RawFrame& frame) noexcept {
  const int ready = system_.wait(file_, timeout_ms);
  if (ready == 0) return Delivery::nothing;
  v4l2_buffer buffer{};
  buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  buffer.memory = V4L2_MEMORY_MMAP;
  if (ready < 0 || system_.control(file_, VIDIOC_DQBUF, &buffer) < 0) {
    if (ready > 0 && errno == EAGAIN) return Delivery::nothing;
    problem_ = "gone, unplugged or out of power";
    return Delivery::lost;
  }
  frame = {};
  frame.buffer = buffer.index;
  if (buffer.index >= buffers_.size()) {
    problem_ = "the driver names a buffer that it does not have";
    return Delivery::lost;
  }
  if (buffer.flags & V4L2_BUF_FLAG_ERROR) {
    release(frame);
    problem_ = "a frame came incomplete";
    return Delivery::incomplete;
  }
  frame.bytes = static_cast<const std::byte*>(buffers_[buffer.index].memory);
  frame.size = std::min<size_t>(buffer.bytesused, buffers_[buffer.index].bytes);
  frame.arrival_ns = monotonic_ns();
  frame.exposed_ns = exposed_ns(buffer);
  frame.count = buffer.sequence;
  return Delivery::frame;
}

void V4l2Camera::release(const RawFrame& frame) noexcept {
  v4l2_buffer buffer{};
  buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  buffer.memory = V4L2_MEMORY_MMAP;
  buffer.index = static_cast<uint32_t>(frame.buffer);
  system_.control(file_, VIDIOC_QBUF, &buffer);
}

void V4l2Camera::close() noexcept {
  if (file_ < 0) return;
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (streaming_) system_.control(file_, VIDIOC_STREAMOFF, &type);
  streaming_ = false;
  for (const Buffer& buffer : buffers_) system_.unmap(buffer.memory, buffer.bytes);
  buffers_.clear();
  system_.close(file_);
  file_ = -1;
}

}  // namespace vdisp
