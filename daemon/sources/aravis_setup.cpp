// aravis_setup.cpp: trigger, rate, exposure, gain and packets: what is configured, or why not.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sources/aravis_setup.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>

#include "daemon/sources/network_link.h"
#include "daemon/sources/raw_pixels.h"

namespace vdisp {
namespace {

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

[[noreturn]] void refuse(const std::string& what) { throw CameraError(CameraFault::unsupported, what); }

/// The first source that is a line of the camera: which one that is, its maker knows ("Line0", "Line1").
std::string line_of(ArvCamera* camera, const std::string& name) {
  guint count = 0;
  const std::unique_ptr<const char*, void (*)(void*)> sources(arv_camera_dup_available_trigger_sources(camera, &count, nullptr), g_free);
  std::string list;
  for (guint i = 0; i < count; ++i) {
    if (std::strncmp(sources.get()[i], "Line", 4) == 0) return sources.get()[i];
    list += (i ? ", " : "") + std::string(sources.get()[i]);
  }
  refuse(name + ": [camera] trigger = line: it has no line, but " + (list.empty() ? "no trigger at all" : list));
}

/// From frame to frame in s; 0: not known.
double set_pace(ArvCamera* camera, const Config& config, const std::string& name) {
  const double rate = config.image_source.rate;
  AravisError error;
  if (config.camera.trigger == "software") {
    if (!arv_camera_is_software_trigger_supported(camera, nullptr)) refuse(name + ": [camera] trigger = software: it has no such trigger");
    arv_camera_set_trigger(camera, "Software", error);
    error.check(name, "set to the software trigger");
    return 1 / (rate > 0 ? rate : default_trigger_rate);
  }
  if (config.camera.trigger == "line") {
    arv_camera_set_trigger(camera, line_of(camera, name).c_str(), error);
    error.check(name, "set to a line trigger");
    return rate > 0 ? 1 / rate : 0;  // the signal's, where it is told
  }
  arv_camera_clear_triggers(camera, nullptr);  // fails where there are none
  if (!arv_camera_is_frame_rate_available(camera, nullptr)) {
    if (rate > 0) refuse(name + ": [image source] rate = " + number(rate) + ": its rate cannot be set; 0 takes what it gives");
    return 0;
  }
  if (rate > 0) {
    double least = 0, most = 0;
    arv_camera_get_frame_rate_bounds(camera, &least, &most, nullptr);
    if (most > 0 && (rate < least || rate > most))
      refuse(name + ": [image source] rate = " + number(rate) +
             " Hz cannot be had; with this size, these pixels and this exposure it takes " + number(least) + " to " + number(most) + " Hz");
    arv_camera_set_frame_rate(camera, rate, error);
    error.check(name, "set to the frame rate");
  }
  const double now = arv_camera_get_frame_rate(camera, nullptr);
  return now > 0 ? 1 / now : 0;
}

/// One of exposure and gain: in its bounds, or refused with them.
double within(double value, double least, double most, bool refuses, const std::string& name, const std::string& key) {
  if (most <= least) return value;
  if (refuses && (value < least || value > most))
    refuse(name + ": [camera] " + key + " = " + number(value) + " cannot be had; it takes " + number(least) + " to " + number(most));
  return std::clamp(value, least, most);
}

void set_light(ArvCamera* camera, const Config& config, const std::string& name, FrameFormat& format) {
  const bool own = config.camera.exposeBy == "camera", fixed = config.camera.exposeBy == "fixed";
  const ArvAuto automatic = own ? ARV_AUTO_CONTINUOUS : ARV_AUTO_OFF;
  if (arv_camera_is_exposure_auto_available(camera, nullptr)) arv_camera_set_exposure_time_auto(camera, automatic, nullptr);
  if (arv_camera_is_gain_auto_available(camera, nullptr)) arv_camera_set_gain_auto(camera, automatic, nullptr);
  if (own) return;
  AravisError error;
  double least = 0, most = 0;
  if (!arv_camera_is_exposure_time_available(camera, nullptr)) refuse(name + ": its exposure cannot be set; [camera] exposeBy = camera");
  arv_camera_get_exposure_time_bounds(camera, &least, &most, nullptr);
  arv_camera_set_exposure_time(camera, within(config.camera.exposure, least, most, fixed, name, "exposure (us)"), error);
  error.check(name, "set to the exposure");
  format.exposure_us = arv_camera_get_exposure_time(camera, nullptr);
  if (!arv_camera_is_gain_available(camera, nullptr)) return;
  arv_camera_get_gain_bounds(camera, &least, &most, nullptr);
  arv_camera_set_gain(camera, within(config.camera.gain, least, most, fixed, name, "gain"), error);
  error.check(name, "set to the gain");
  format.gain_db = arv_camera_get_gain(camera, nullptr);
}

NetworkLink link_of(ArvCamera* camera) {
  GSocketAddress* address = arv_gv_device_get_interface_address(ARV_GV_DEVICE(arv_camera_get_device(camera)));
  if (!G_IS_INET_SOCKET_ADDRESS(address)) return {};
  const std::unique_ptr<char, void (*)(void*)> text(
      g_inet_address_to_string(g_inet_socket_address_get_address(G_INET_SOCKET_ADDRESS(address))), g_free);
  return network_link(text.get());
}

void set_packets(ArvCamera* camera, const Config& config, const std::string& name, const FrameFormat& format) {
  if (!arv_camera_is_gv_device(camera)) return;
  const NetworkLink link = link_of(camera);
  const int64_t bytes = static_cast<int64_t>(format.width) * format.height * raw_pixel_bytes(format);
  if (const std::string wrong = refuse_rate(link, bytes, format.period_s > 0 ? 1 / format.period_s : 0); !wrong.empty())
    refuse(name + ": " + wrong);
  const int size = config.camera.packetSize;
  AravisError error;
  if (size == 0) {
    arv_camera_gv_auto_packet_size(camera, error);
    return error.check(name, "asked which packets get through");
  }
  if (const std::string wrong = refuse_packets(link, size); !wrong.empty()) refuse(name + ": " + wrong);
  arv_camera_gv_set_packet_size_adjustment(camera, ARV_GV_PACKET_SIZE_ADJUSTMENT_NEVER);
  arv_camera_gv_set_packet_size(camera, size, error);
  error.check(name, "set to the packet size");
  const guint now = arv_camera_gv_get_packet_size(camera, nullptr);
  if (static_cast<int>(now) != size) refuse(name + ": [camera] packetSize = " + std::to_string(size) + ": it takes " + std::to_string(now));
}

}  // namespace

void AravisError::check(const std::string& name, const char* doing) const {
  if (!error_) return;
  CameraFault fault = CameraFault::failed;
  std::string what = name + ", " + doing + ": " + error_->message;
  if (error_->domain == ARV_DEVICE_ERROR) {
    switch (error_->code) {
      case ARV_DEVICE_ERROR_NOT_CONTROLLER:
      case ARV_DEVICE_ERROR_PROTOCOL_ERROR_ACCESS_DENIED:
      case ARV_DEVICE_ERROR_PROTOCOL_ERROR_BUSY:
        fault = CameraFault::busy;
        what += "; another program controls it";
        break;
      case ARV_DEVICE_ERROR_NOT_FOUND:
      case ARV_DEVICE_ERROR_NOT_CONNECTED:
      case ARV_DEVICE_ERROR_TIMEOUT: fault = CameraFault::absent; break;
      default: break;
    }
  }
  throw CameraError(fault, what);
}

FrameFormat set_up(ArvCamera* camera, const Config& config, const std::string& name) {
  FrameFormat format = set_shape(camera, config, name);
  // Exposure bounds the rate, and the rate of some cameras the exposure: the rate has the last word, and is refused if it cannot be.
  set_light(camera, config, name, format);
  format.period_s = set_pace(camera, config, name);
  set_packets(camera, config, name, format);
  AravisError error;
  arv_camera_set_acquisition_mode(camera, ARV_ACQUISITION_MODE_CONTINUOUS, error);
  error.check(name, "set to take one frame after the other");
  return format;
}

}  // namespace vdisp
