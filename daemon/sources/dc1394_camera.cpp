// dc1394_camera.cpp: modes and rates of the IIDC standard; the STH-MDCS2 sends a pixel of each view by turns and calls it YUV422.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sources/dc1394_camera.h"

#include <poll.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>

#include "daemon/core/clock.h"
#include "daemon/sources/dc1394.h"
#include "daemon/sources/raw_pixels.h"

namespace vdisp {
namespace {

constexpr uint32_t buffers = 4;
constexpr int64_t oldest_ns = 3'000'000'000;  // as many frames at 1.875 Hz, and one more
constexpr uint64_t colour_register = 0x50c;   // Videre: bit 31 of it, as in its driver
constexpr uint64_t memory_start = 0xf0000 + 0x800, memory_quads = 1024;
constexpr int default_width = 640, default_height = 480;
constexpr double default_rate = 30;

struct Kind {
  dc1394color_coding_t coding;
  FramePixels pixels;
  const char* key;
};
/// In the order in which `pixels = auto` takes them.
constexpr std::array<Kind, 4> kinds{{{DC1394_COLOR_CODING_MONO8, FramePixels::gray8, "gray8"},
                                     {DC1394_COLOR_CODING_YUV422, FramePixels::uyvy, "uyvy"},
                                     {DC1394_COLOR_CODING_RGB8, FramePixels::rgb8, "rgb8"},
                                     {DC1394_COLOR_CODING_MONO16, FramePixels::gray16, "gray16"}}};

const Kind* kind_of(dc1394color_coding_t coding) {
  const auto found = std::find_if(kinds.begin(), kinds.end(), [&](const Kind& kind) { return kind.coding == coding; });
  return found == kinds.end() ? nullptr : &*found;
}

}  // namespace

Dc1394Camera::Dc1394Camera(uint64_t guid, const Config& config)
    : guid_(guid), config_(config), name_("FireWire camera " + guid_text(guid)) {}

void Dc1394Camera::refuse(CameraFault fault, const std::string& what) {
  const std::string line = name_ + ": " + what;
  close();
  throw CameraError(fault, line);
}

void Dc1394Camera::must(dc1394error_t done, const char* what) {
  if (done == DC1394_SUCCESS) return;
  if (done == DC1394_NO_BANDWIDTH || done == DC1394_NO_ISO_CHANNEL)
    refuse(CameraFault::failed, "the bus has no bandwidth left; use a lower rate or size, or a bus for each camera");
  refuse(CameraFault::failed, std::string(what) + ": " + dc1394_error_get_string(done));
}

/// By turns the container is YUV422, whatever the pixels are.
dc1394video_mode_t Dc1394Camera::choose_mode(FrameFormat& format) {
  const bool turns = config_.camera.views == "turns";
  const auto width = static_cast<uint32_t>(config_.image_source.width ? config_.image_source.width : default_width);
  const auto height = static_cast<uint32_t>(config_.image_source.height ? config_.image_source.height : default_height);
  const std::string& wanted = config_.camera.pixels;
  dc1394video_modes_t modes;
  must(dc1394_video_get_supported_modes(camera_, &modes), "its modes");
  const Kind* best = nullptr;
  dc1394video_mode_t chosen = DC1394_VIDEO_MODE_MIN;
  std::string list;
  for (uint32_t i = 0; i < modes.num; ++i) {
    dc1394color_coding_t coding;
    uint32_t w = 0, h = 0;
    if (modes.modes[i] >= DC1394_VIDEO_MODE_EXIF ||
        dc1394_get_color_coding_from_video_mode(camera_, modes.modes[i], &coding) != DC1394_SUCCESS ||
        dc1394_get_image_size_from_video_mode(camera_, modes.modes[i], &w, &h) != DC1394_SUCCESS)
      continue;
    const Kind* kind = kind_of(coding);
    if (!kind || (turns && coding != DC1394_COLOR_CODING_YUV422)) continue;
    list += (list.empty() ? "" : ", ") + std::to_string(w) + "x" + std::to_string(h) + (turns ? "" : std::string(" ") + kind->key);
    if (w != width || h != height || (!turns && wanted != "auto" && wanted != kind->key) || (best && best <= kind)) continue;
    best = kind;
    chosen = modes.modes[i];
  }
  if (!best)
    refuse(CameraFault::unsupported, "it has no mode of " + std::to_string(width) + "x" + std::to_string(height) +
                                         (turns              ? " in YUV422, which holds both views"
                                          : wanted == "auto" ? ""
                                                             : " " + wanted) +
                                         "; it has " + (list.empty() ? "none that can be used" : list));
  format.width = static_cast<int>(width);
  format.height = static_cast<int>(height);
  format.pixels = turns ? FramePixels::gray8 : best->pixels;
  format.views = turns ? FrameViews::by_turns : FrameViews::one;
  format.stride = static_cast<ptrdiff_t>(width) * raw_pixel_bytes(format);
  return chosen;
}

/// The nearest the camera has to what is wanted.
void Dc1394Camera::choose_rate(dc1394video_mode_t mode, FrameFormat& format) {
  dc1394framerates_t rates;
  must(dc1394_video_get_supported_framerates(camera_, mode, &rates), "its rates");
  const double wanted = config_.image_source.rate > 0 ? config_.image_source.rate : default_rate;
  double nearest = 0;
  dc1394framerate_t chosen = DC1394_FRAMERATE_MIN;
  for (uint32_t i = 0; i < rates.num; ++i) {
    float rate = 0;
    dc1394_framerate_as_float(rates.framerates[i], &rate);
    if (nearest > 0 && std::abs(static_cast<double>(rate) - wanted) >= std::abs(nearest - wanted)) continue;
    nearest = static_cast<double>(rate);
    chosen = rates.framerates[i];
  }
  must(dc1394_video_set_framerate(camera_, chosen), "its rate");
  if (nearest > 0) format.period_s = period_s_ = 1 / nearest;
}

/// A colour head gives a mosaic; which one drivers disagree about, so it is a setting.
void Dc1394Camera::check_colour() {
  uint32_t value = 0;
  if (!videre() || dc1394_get_control_register(camera_, colour_register, &value) != DC1394_SUCCESS) return;
  const bool colour = value >> 31, told = config_.image_source.bayer != "none";
  if (colour && !told)
    refuse(CameraFault::unsupported,
           "it is a colour camera: [image source] bayer must say its mosaic; grbg is the most common, rggb and gbrg occur");
  if (!colour && told)
    refuse(CameraFault::unsupported, "it is a gray camera: [image source] bayer must be none, is " + config_.image_source.bayer);
}

FrameFormat Dc1394Camera::open() {
  close();
  bus_ = open_dc1394_bus();
  if (!bus_) refuse(CameraFault::failed, "the FireWire bus cannot be opened");
  camera_ = dc1394_camera_new(bus_.get(), guid_);
  if (!camera_) {
    if (const std::string denied = dc1394_denied(); !denied.empty()) refuse(CameraFault::denied, denied);
    std::string there;
    for (const std::string& guid : find_dc1394()) there += (there.empty() ? "" : ", ") + guid;
    refuse(CameraFault::absent, "it is not on the bus; there is " + (there.empty() ? "none" : there));
  }
  FrameFormat format;
  check_colour();
  dc1394_video_set_iso_speed(camera_, DC1394_ISO_SPEED_400);
  const dc1394video_mode_t mode = choose_mode(format);
  must(dc1394_video_set_mode(camera_, mode), "its mode");
  choose_rate(mode, format);
  prepare_trigger();
  prepare_exposure();
  must(dc1394_capture_setup(camera_, buffers, DC1394_CAPTURE_FLAGS_DEFAULT), "capture");
  capturing_ = true;
  must(dc1394_video_set_transmission(camera_, DC1394_ON), "transmission");
  return format;
}

void Dc1394Camera::prepare_trigger() {
  const std::string& trigger = config_.camera.trigger;
  if (trigger == "free") {
    dc1394_external_trigger_set_power(camera_, DC1394_OFF);  // a camera without trigger has it off
    return;
  }
  const dc1394trigger_source_t source = trigger == "software" ? DC1394_TRIGGER_SOURCE_SOFTWARE : DC1394_TRIGGER_SOURCE_0;
  if (dc1394_external_trigger_set_power(camera_, DC1394_ON) != DC1394_SUCCESS ||
      (dc1394_external_trigger_set_source(camera_, source) != DC1394_SUCCESS && trigger == "software"))
    refuse(CameraFault::unsupported, "it takes no trigger = " + trigger + "; needed is free");
  dc1394_external_trigger_set_mode(camera_, DC1394_TRIGGER_MODE_0);
}

void Dc1394Camera::trigger() noexcept {
  const std::lock_guard lock(features_);
  if (camera_) dc1394_software_trigger_set_power(camera_, DC1394_ON);
}

Delivery Dc1394Camera::wait(int timeout_ms, RawFrame& frame) noexcept {
  pollfd ready{dc1394_capture_get_fileno(camera_), POLLIN, 0};
  const int count = ::poll(&ready, 1, timeout_ms);
  dc1394video_frame_t* video = nullptr;
  if (count == 0 || (count < 0 && errno == EINTR)) return Delivery::nothing;
  if (count > 0 && dc1394_capture_dequeue(camera_, DC1394_CAPTURE_POLICY_POLL, &video) == DC1394_SUCCESS) {
    if (!video) return Delivery::nothing;
    frame = {};
    ++count_;
    if (dc1394_capture_is_frame_corrupt(camera_, video)) {
      dc1394_capture_enqueue(camera_, video);
      problem_ = "a frame came incomplete";
      return Delivery::incomplete;
    }
    frame.bytes = reinterpret_cast<const std::byte*>(video->image);
    frame.size = video->image_bytes;
    frame.arrival_ns = monotonic_ns();
    // The library's time is the wall clock's, of the last packet, and the same for all cameras of the bus.
    const int64_t age_ns = static_cast<int64_t>(wall_clock_ns()) - static_cast<int64_t>(video->timestamp) * 1000;
    const bool stepped = age_ns < 0 || age_ns > oldest_ns;  // that clock, while the frame waited here
    frame.exposed_ns = frame.arrival_ns - (stepped ? 0 : age_ns) - static_cast<int64_t>(exposure_us_ * 500);
    frame.count = count_;
    frame.buffer = reinterpret_cast<int64_t>(video);
    return Delivery::frame;
  }
  problem_ = "gone from the bus";
  return Delivery::lost;
}

void Dc1394Camera::release(const RawFrame& frame) noexcept {
  dc1394_capture_enqueue(camera_, reinterpret_cast<dc1394video_frame_t*>(frame.buffer));
}

void Dc1394Camera::close() noexcept {
  if (capturing_) {
    dc1394_video_set_transmission(camera_, DC1394_OFF);
    dc1394_capture_stop(camera_);
  }
  capturing_ = false;
  if (camera_) dc1394_camera_free(camera_);
  camera_ = nullptr;
  bus_.reset();
}

/// A text of at most 4 KB, its bytes in quadlets with the first one high, up to a quadlet of 0 or of ones.
std::string Dc1394Camera::stored_calibration() {
  if (!camera_ || !videre()) return {};
  std::string text;
  for (uint64_t i = 0; i < memory_quads; ++i) {
    uint32_t quad = 0;
    if (dc1394_get_control_registers(camera_, memory_start + 4 * i, &quad, 1) != DC1394_SUCCESS || quad == 0 || quad == 0xffffffff) break;
    for (int shift = 24; shift >= 0; shift -= 8)
      if (const char c = static_cast<char>(quad >> shift & 255); c != '\0') text += c;
  }
  return text.starts_with("# SVS") ? text : std::string();
}

}  // namespace vdisp
