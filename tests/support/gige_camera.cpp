// gige_camera.cpp: a stand-in for a GigE camera that sees something: Aravis' own, with a picture, and the time in its first 64 pixels.
// SPDX-License-Identifier: Apache-2.0
//   vdisp-gige-camera ADDRESS SERIAL PICTURE.pgm [MS]   MS: the time stamps of every other frame are so much too late
//   SIGUSR1: it sends no more frames and answers as before, until it is started anew by its master
#include <arv.h>
#include <poll.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

namespace {

/// Gray, of any size: a larger frame sees it again.
struct Picture {
  int width = 0, height = 0;
  std::vector<uint8_t> pixels;
  double late_ms = 0;
  bool odd = false;
  unsigned long sent = 0;
};

Picture read_pgm(const char* name) {
  Picture picture;
  std::ifstream in(name, std::ios::binary);
  std::string magic;
  int most = 0;
  in >> magic >> picture.width >> picture.height >> most;
  in.get();
  if (magic != "P5" || most != 255 || picture.width <= 0 || picture.height <= 0) return {};
  picture.pixels.resize(static_cast<size_t>(picture.width) * static_cast<size_t>(picture.height));
  in.read(reinterpret_cast<char*>(picture.pixels.data()), static_cast<std::streamsize>(picture.pixels.size()));
  return picture;
}

/// As bright as it is with 5 ms and no gain; in one byte a pixel, or the value as the high byte of two.
void draw(ArvBuffer* buffer, void* data, guint32 exposure_us, guint32 gain_db, ArvPixelFormat format) {
  Picture& picture = *static_cast<Picture*>(data);
  const int bytes = static_cast<int>(ARV_PIXEL_FORMAT_BIT_PER_PIXEL(format) / 8);
  size_t size = 0;
  auto* out = static_cast<uint8_t*>(const_cast<void*>(arv_buffer_get_data(buffer, &size)));
  gint x0 = 0, y0 = 0, width = 0, height = 0;
  arv_buffer_get_image_region(buffer, &x0, &y0, &width, &height);
  const double light = exposure_us / 5000.0 * std::pow(10, gain_db / 20.0);
  const auto time = static_cast<uint64_t>(arv_buffer_get_timestamp(buffer));
  ++picture.sent;
  if ((picture.odd = !picture.odd)) arv_buffer_set_timestamp(buffer, time + static_cast<uint64_t>(picture.late_ms * 1e6));
  uint8_t levels[256];
  for (int i = 0; i < 256; ++i) levels[i] = static_cast<uint8_t>(std::min(255.0, i * light));
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      uint8_t level = levels[picture.pixels[static_cast<size_t>(y % picture.height) * static_cast<size_t>(picture.width) +
                                            static_cast<size_t>(x % picture.width)]];
      if (y == 0 && x < 64) level = time >> x & 1 ? 255 : 0;
      uint8_t* pixel = out + (static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)) * static_cast<size_t>(bytes);
      for (int i = 0; i < bytes; ++i) pixel[i] = bytes == 2 && i == 0 ? 0x55 : level;
    }
  }
}

}  // namespace

/// In place of GLib's. Aravis' camera waits for its next frame in steps of at most 100 ms; where the time of the frame passes while it
/// works out the step, that difference of unsigned numbers is 100 ms too, and three frames at 30 Hz are not sent. Short steps send them.
extern "C" gint g_poll(GPollFD* descriptors, guint count, gint timeout_ms) {
  static_assert(sizeof(GPollFD) == sizeof(pollfd));
  constexpr gint step_ms = 2;
  return poll(reinterpret_cast<pollfd*>(descriptors), count, timeout_ms < 0 ? step_ms : std::min(timeout_ms, step_ms));
}

int main(int argc, char** argv) {
  if (argc < 4) return 64;
  Picture picture = read_pgm(argv[3]);
  if (argc > 4) picture.late_ms = std::atof(argv[4]);
  if (picture.pixels.empty()) {
    std::fprintf(stderr, "%s: not a PGM of 8 bits\n", argv[3]);
    return 66;
  }
  sigset_t told;
  sigemptyset(&told);
  for (int signal : {SIGTERM, SIGINT, SIGUSR1}) sigaddset(&told, signal);
  pthread_sigmask(SIG_BLOCK, &told, nullptr);  // of the camera's thread too
  ArvGvFakeCamera* camera = arv_gv_fake_camera_new(argv[1], argv[2]);
  if (!arv_gv_fake_camera_is_running(camera)) {
    std::fprintf(stderr, "%s: no camera can be there\n", argv[1]);
    return 69;
  }
  arv_fake_camera_set_fill_pattern(arv_gv_fake_camera_get_fake_camera(camera), draw, &picture);
  for (int signal = SIGUSR1; signal == SIGUSR1;) {
    sigwait(&told, &signal);
    if (signal == SIGUSR1)
      arv_fake_camera_write_register(arv_gv_fake_camera_get_fake_camera(camera), ARV_FAKE_CAMERA_REGISTER_ACQUISITION, 0);
  }
  g_object_unref(camera);
  std::printf("sent %lu frames\n", picture.sent);
  return 0;
}
