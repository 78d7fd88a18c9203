// dc1394_standin.cpp: a stand-in for libdc1394 with cameras that the simulator sees through. It proves our logic, never the hardware.
// SPDX-License-Identifier: Apache-2.0
//
// Preloaded, or linked before the library. VDISP_STANDIN is a list of words:
//   mdcs2         one STH-MDCS2 (both views by turns in YUV422);   pair       two gray cameras
//   right-first   its first byte is the right view's;              colour     it says that it is a colour head
//   calibration   its memory holds the simulator's calibration;    untrigger  it takes no trigger
//   full          the bus has no bandwidth;                        corrupt    every third frame comes incomplete
// VDISP_STANDIN_SIM is the renderer (vdisp_sim.so). While the file VDISP_STANDIN_GONE exists the cameras are unplugged.
#include <dc1394/dc1394.h>
#include <dlfcn.h>
#include <sys/eventfd.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <memory>
#include <string>
#include <vector>

#include "daemon/sim/simulator.h"

namespace {

using namespace vdisp;
constexpr uint64_t first_guid = 0x0055050000000001;

bool told(const char* word) {
  const char* words = std::getenv("VDISP_STANDIN");
  return words && std::strstr(words, word);
}

bool gone() {
  const char* file = std::getenv("VDISP_STANDIN_GONE");
  return file && access(file, F_OK) == 0;
}

struct Standin {
  dc1394camera_t base{};  // first: the library's users hold a pointer to it
  uint32_t width = 640, height = 480;
  double rate = 30, exposure = 5e-3, gain = 0;
  bool software = false;
  int file = -1;
  int64_t start_us = 0, sequence = 0;
  std::unique_ptr<sim::Simulator> simulator;
  sim_section scene;
  std::vector<std::byte> view[2];
  std::vector<uint8_t> pixels;
  dc1394video_frame_t frame{};
  std::string memory;
};

Standin& of(dc1394camera_t* camera) { return *reinterpret_cast<Standin*>(camera); }

int64_t wall_us() {
  timespec now;
  clock_gettime(CLOCK_REALTIME, &now);
  return now.tv_sec * 1'000'000LL + now.tv_nsec / 1000;
}

void make_simulator(Standin& s) {
  s.scene.width = static_cast<int>(s.width);
  s.scene.height = static_cast<int>(s.height);
  s.scene.rate = s.rate;
  const char* path = std::getenv("VDISP_STANDIN_SIM");
  void* module = path ? dlopen(path, RTLD_NOW | RTLD_LOCAL) : nullptr;
  auto* make = module ? reinterpret_cast<sim::MakeSimulator*>(dlsym(module, sim::make_simulator_symbol)) : nullptr;
  if (make) s.simulator.reset(make(s.scene));
  if (!s.simulator) {
    std::fprintf(stderr, "dc1394_standin: VDISP_STANDIN_SIM must name the renderer vdisp_sim.so\n");
    std::abort();
  }
  for (auto& view : s.view) view.resize(s.width * s.height);
}

/// As smallvcal writes it, all that rectification needs.
std::string ini_of(const Calibration& c) {
  std::string text = "# SVS Engine v 4.0 Stereo Camera Parameter File\n\n[image]\nhave_rect 1\n\n[stereo]\nframe 1.0\n\n[external]\n";
  char line[400];
  const auto& raw = *c.raw;
  std::snprintf(line, sizeof line, "Tx %.9f\nTy 0\nTz 0\nRx 0\nRy 0\nRz 0\n", raw[1].projection[3] / raw[1].projection[0] * 1000);
  text += line;
  for (size_t side = 0; side < 2; ++side) {
    const RawCamera& r = raw[side];
    text += side == 0 ? "\n[left camera]\n" : "\n[right camera]\n";
    std::snprintf(line, sizeof line,
                  "pwidth %d\npheight %d\nCx %.9f\nCy %.9f\nf %.9f\nfy %.9f\nkappa1 %.9f\nkappa2 %.9f\nkappa3 %.9f\ntau1 %.9f\ntau2 %.9f\n",
                  c.width, c.height, r.k[2], r.k[5], r.k[0], r.k[4], r.distortion[0], r.distortion[1], r.distortion[4], r.distortion[2],
                  r.distortion[3]);
    text += line;
    text += "proj\n";
    for (size_t row = 0; row < 3; ++row) {
      const double scale = row == 0 ? 1000 : 1;  // px m to px mm
      const double* p = &r.projection[row * 4];
      std::snprintf(line, sizeof line, "%.12e %.12e %.12e %.12e\n", p[0], p[1], p[2], p[3] * scale);
      text += line;
    }
    text += "rect\n";
    for (size_t row = 0; row < 3; ++row) {
      const double* p = &r.rectification[row * 3];
      std::snprintf(line, sizeof line, "%.12e %.12e %.12e\n", p[0], p[1], p[2]);
      text += line;
    }
  }
  return text + "\n[global]\nGTx 0\n";
}

/// A longer exposure and more gain make it brighter; 5 ms and 0 dB leave it as the simulator has it.
uint8_t exposed(const Standin& s, std::byte value) {
  const double light = static_cast<double>(std::to_integer<int>(value)) * s.exposure / 5e-3 * std::pow(10, s.gain / 20);
  return static_cast<uint8_t>(std::min(light, 255.0));
}

void draw(Standin& s) {
  // Both cameras of a pair show the same moment.
  s.sequence = static_cast<int64_t>(std::floor(static_cast<double>(wall_us()) * 1e-6 * s.rate));
  const auto first = static_cast<int64_t>(std::floor(static_cast<double>(s.start_us) * 1e-6 * s.rate));
  s.simulator->render(static_cast<uint64_t>(std::max<int64_t>(s.sequence - first, 0)), s.view[0].data(), s.view[1].data(), s.width);
  uint8_t light[256];
  for (int i = 0; i < 256; ++i) light[i] = exposed(s, static_cast<std::byte>(i));
  const bool both = told("mdcs2");
  const size_t count = s.width * s.height, side = s.base.guid == first_guid ? 0 : 1, early = told("right-first") ? 1 : 0;
  const auto level = [&](size_t view, size_t i) { return light[std::to_integer<uint8_t>(s.view[view][i])]; };
  for (size_t i = 0; i < count; ++i) {
    if (both) {
      s.pixels[2 * i] = level(early, i);
      s.pixels[2 * i + 1] = level(1 - early, i);
    } else {
      s.pixels[i] = level(side, i);
    }
  }
  s.frame.image = s.pixels.data();
  s.frame.image_bytes = static_cast<uint32_t>(s.pixels.size());
  s.frame.timestamp = static_cast<uint64_t>(static_cast<double>(s.sequence) / s.rate * 1e6);
  // Taken before the wall clock was put an hour back, or on.
  if (told("stepped") && s.sequence % 3 != 0) s.frame.timestamp += s.sequence % 3 == 1 ? 3'600'000'000 : -3'600'000'000;
  s.frame.camera = &s.base;
}

}  // namespace

extern "C" {

dc1394error_t dc1394_log_register_handler(dc1394log_t, void (*)(dc1394log_t, const char*, void*), void*) { return DC1394_SUCCESS; }
dc1394_t* dc1394_new(void) { return reinterpret_cast<dc1394_t*>(new char); }
void dc1394_free(dc1394_t* bus) { delete reinterpret_cast<char*>(bus); }

dc1394error_t dc1394_camera_enumerate(dc1394_t*, dc1394camera_list_t** list) {
  *list = new dc1394camera_list_t{};
  (*list)->num = gone() ? 0 : told("mdcs2") ? 1 : told("pair") ? 2 : 0;
  (*list)->ids = new dc1394camera_id_t[2]{{0, first_guid}, {0, first_guid + 1}};
  return DC1394_SUCCESS;
}
void dc1394_camera_free_list(dc1394camera_list_t* list) {
  delete[] list->ids;
  delete list;
}

dc1394camera_t* dc1394_camera_new(dc1394_t*, uint64_t guid) {
  if (gone() || guid < first_guid || guid >= first_guid + (told("mdcs2") ? 1 : 2)) return nullptr;
  auto* s = new Standin;
  s->base.guid = guid;
  s->base.vendor_id = 0x5505;
  return &s->base;
}
void dc1394_camera_free(dc1394camera_t* camera) { delete &of(camera); }

dc1394error_t dc1394_video_get_supported_modes(dc1394camera_t*, dc1394video_modes_t* modes) {
  *modes = {};
  for (const dc1394video_mode_t mode : {DC1394_VIDEO_MODE_320x240_YUV422, DC1394_VIDEO_MODE_640x480_YUV422, DC1394_VIDEO_MODE_640x480_MONO8,
                                        DC1394_VIDEO_MODE_1280x960_YUV422})
    if (told("mdcs2") == (mode != DC1394_VIDEO_MODE_640x480_MONO8)) modes->modes[modes->num++] = mode;
  return DC1394_SUCCESS;
}
dc1394error_t dc1394_video_get_supported_framerates(dc1394camera_t*, dc1394video_mode_t mode, dc1394framerates_t* rates) {
  *rates = {};
  for (const dc1394framerate_t rate : {DC1394_FRAMERATE_7_5, DC1394_FRAMERATE_15, DC1394_FRAMERATE_30})
    if (mode != DC1394_VIDEO_MODE_1280x960_YUV422 || rate == DC1394_FRAMERATE_7_5) rates->framerates[rates->num++] = rate;
  return DC1394_SUCCESS;
}
dc1394error_t dc1394_video_set_framerate(dc1394camera_t* camera, dc1394framerate_t rate) {
  of(camera).rate = 7.5 * (1 << (rate - DC1394_FRAMERATE_7_5));
  return DC1394_SUCCESS;
}
dc1394error_t dc1394_video_set_mode(dc1394camera_t* camera, dc1394video_mode_t mode) {
  return dc1394_get_image_size_from_video_mode(camera, mode, &of(camera).width, &of(camera).height);
}
dc1394error_t dc1394_video_set_iso_speed(dc1394camera_t*, dc1394speed_t) { return DC1394_SUCCESS; }
dc1394error_t dc1394_video_set_transmission(dc1394camera_t*, dc1394switch_t) { return DC1394_SUCCESS; }

dc1394error_t dc1394_external_trigger_set_power(dc1394camera_t* camera, dc1394switch_t power) {
  if (told("untrigger")) return DC1394_FUNCTION_NOT_SUPPORTED;
  of(camera).software = power == DC1394_ON;
  return DC1394_SUCCESS;
}
dc1394error_t dc1394_external_trigger_set_source(dc1394camera_t*, dc1394trigger_source_t) { return DC1394_SUCCESS; }
dc1394error_t dc1394_external_trigger_set_mode(dc1394camera_t*, dc1394trigger_mode_t) { return DC1394_SUCCESS; }
dc1394error_t dc1394_software_trigger_set_power(dc1394camera_t* camera, dc1394switch_t) {
  const uint64_t one = 1;
  if (of(camera).software && of(camera).file >= 0 && write(of(camera).file, &one, sizeof one) < 0) return DC1394_FAILURE;
  return DC1394_SUCCESS;
}

dc1394error_t dc1394_feature_is_present(dc1394camera_t*, dc1394feature_t, dc1394bool_t* present) {
  return *present = DC1394_TRUE, DC1394_SUCCESS;
}
dc1394error_t dc1394_feature_set_mode(dc1394camera_t*, dc1394feature_t, dc1394feature_mode_t) { return DC1394_SUCCESS; }
dc1394error_t dc1394_feature_has_absolute_control(dc1394camera_t*, dc1394feature_t, dc1394bool_t* has) {
  return *has = DC1394_TRUE, DC1394_SUCCESS;
}
dc1394error_t dc1394_feature_set_absolute_control(dc1394camera_t*, dc1394feature_t, dc1394switch_t) { return DC1394_SUCCESS; }
dc1394error_t dc1394_feature_set_absolute_value(dc1394camera_t* camera, dc1394feature_t feature, float value) {
  (feature == DC1394_FEATURE_SHUTTER ? of(camera).exposure : of(camera).gain) = static_cast<double>(value);
  return DC1394_SUCCESS;
}

dc1394error_t dc1394_capture_setup(dc1394camera_t* camera, uint32_t, uint32_t) {
  if (told("full")) return DC1394_NO_BANDWIDTH;
  Standin& s = of(camera);
  make_simulator(s);
  s.pixels.resize(s.width * s.height * (told("mdcs2") ? 2 : 1));
  // The scene begins when the program does, for both cameras.
  static const int64_t begin = wall_us();
  s.start_us = begin;
  if (s.software) {
    s.file = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
  } else {
    s.file = timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC);
    const auto period = static_cast<long>(1e9 / s.rate);
    const itimerspec time{{0, period}, {0, period}};
    timerfd_settime(s.file, 0, &time, nullptr);
  }
  return DC1394_SUCCESS;
}
dc1394error_t dc1394_capture_stop(dc1394camera_t* camera) {
  if (of(camera).file >= 0) close(of(camera).file);
  of(camera).file = -1;
  return DC1394_SUCCESS;
}
int dc1394_capture_get_fileno(dc1394camera_t* camera) { return of(camera).file; }
dc1394error_t dc1394_capture_dequeue(dc1394camera_t* camera, dc1394capture_policy_t, dc1394video_frame_t** frame) {
  *frame = nullptr;
  if (gone()) return DC1394_FAILURE;
  uint64_t due = 0;
  if (read(of(camera).file, &due, sizeof due) < 0) return DC1394_SUCCESS;
  const int64_t before = of(camera).sequence;
  draw(of(camera));
  if (of(camera).sequence == before) return DC1394_SUCCESS;  // twice within one period of the clock: the next one
  *frame = &of(camera).frame;
  return DC1394_SUCCESS;
}
dc1394error_t dc1394_capture_enqueue(dc1394camera_t*, dc1394video_frame_t*) { return DC1394_SUCCESS; }
dc1394bool_t dc1394_capture_is_frame_corrupt(dc1394camera_t* camera, dc1394video_frame_t*) {
  return told("corrupt") && of(camera).sequence % 3 == 0 ? DC1394_TRUE : DC1394_FALSE;
}

dc1394error_t dc1394_get_control_registers(dc1394camera_t* camera, uint64_t offset, uint32_t* value, uint32_t) {
  if (offset == 0x50c) return *value = told("colour") ? 0x80000000u : 0, DC1394_SUCCESS;
  Standin& s = of(camera);
  if (told("calibration") && s.memory.empty()) s.memory = ini_of(s.simulator->calibration());
  const size_t at = offset - 0xf0800;
  *value = 0xffffffff;
  if (at < s.memory.size()) {
    *value = 0;
    for (size_t i = 0; i < 4; ++i) *value = *value << 8 | static_cast<uint8_t>(at + i < s.memory.size() ? s.memory[at + i] : 0);
  }
  return DC1394_SUCCESS;
}

}  // extern "C"
