// rectify_maps.h: raw images that asan watches to their last pixel, and maps that hurt.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "tests/kernels/check.h"

#if defined(__SANITIZE_ADDRESS__)
#include <sanitizer/asan_interface.h>
#endif

namespace vdisp::kernels {

/// Where each pixel of the result comes from, as OpenCV keeps it.
struct Maps {
  Maps(int width, int height, const std::function<std::pair<double, double>(int x, int y)>& source)
      : whole(2 * width, height), part(width, height) {
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const auto [u, v] = source(x, y);
        const int at_u = static_cast<int>(std::lround(u * 32)), at_v = static_cast<int>(std::lround(v * 32));
        whole.at(2 * x, y) = static_cast<int16_t>(std::clamp(at_u >> 5, -32768, 32767));
        whole.at(2 * x + 1, y) = static_cast<int16_t>(std::clamp(at_v >> 5, -32768, 32767));
        part.at(x, y) = static_cast<uint16_t>((at_v & 31) << 5 | (at_u & 31));
      }
    }
  }
  RectifyTable table(View8 raw) { return {whole.plane(), part.plane(), raw}; }
  Picture<int16_t> whole;
  Picture<uint16_t> part;
};

/// A raw image whose memory ends with its last pixel; what lies between its rows is poisoned where asan is there to see it.
class Raw {
 public:
  Raw(int width, int height, int extra_stride) : width_(width), height_(height), stride_(width + extra_stride) {
    bytes_ = std::make_unique<uint8_t[]>(size());
    std::minstd_rand random(static_cast<uint32_t>(width * 7919 + height));
    for (size_t i = 0; i < size(); ++i) bytes_[i] = static_cast<uint8_t>(random() >> 8);
    poison(true);
  }
  ~Raw() { poison(false); }
  Raw(const Raw&) = delete;
  Raw& operator=(const Raw&) = delete;
  View8 view() const { return {bytes_.get(), width_, height_, stride_}; }
  void set(uint8_t value) {
    for (int y = 0; y < height_; ++y) std::memset(bytes_.get() + y * stride_, value, static_cast<size_t>(width_));
  }

 private:
  size_t size() const { return static_cast<size_t>(stride_ * (height_ - 1) + width_); }
  void poison([[maybe_unused]] bool on) {
#if defined(__SANITIZE_ADDRESS__)
    for (int y = 0; y + 1 < height_; ++y) {
      const uint8_t* behind = bytes_.get() + y * stride_ + width_;
      const auto gap = static_cast<size_t>(stride_ - width_);
      on ? ASAN_POISON_MEMORY_REGION(behind, gap) : ASAN_UNPOISON_MEMORY_REGION(behind, gap);
    }
#endif
  }
  int width_, height_;
  ptrdiff_t stride_;
  std::unique_ptr<uint8_t[]> bytes_;
};

struct Map {
  const char* name;
  std::function<std::pair<double, double>(int, int)> source;
};

/// Rotation, scale and radial distortion about the middle.
inline std::function<std::pair<double, double>(int, int)> lens(int width, int height, double angle, double scale, double k) {
  return [=](int x, int y) {
    const double f = width, u = (x - width / 2.0) / f, v = (y - height / 2.0) / f, radial = scale * (1 + k * (u * u + v * v));
    return std::pair{width / 2.0 + f * radial * (std::cos(angle) * u - std::sin(angle) * v),
                     height / 2.0 + f * radial * (std::sin(angle) * u + std::cos(angle) * v)};
  };
}

inline std::vector<Map> maps_for(int width, int height) {
  const auto random = std::make_shared<std::minstd_rand>(3);
  const auto noise = [random](double range) { return range * static_cast<double>((*random)() % 4096) / 4096; };
  return {
      {"identity",
       [](int x, int y) {
         return std::pair<double, double>{x, y};
       }},
      {"half a pixel",
       [](int x, int y) {
         return std::pair{x + 0.5, y + 0.5};
       }},
      {"partly outside",
       [](int x, int y) {
         return std::pair{x - 5.3, y - 1.7};
       }},
      {"far outside",
       [](int x, int y) {
         return std::pair{x * 40.0 - 9000, y * 3 + 30000.0};
       }},
      {"lens", lens(width, height, 0.01, 1, -0.2)},
      {"strong lens", lens(width, height, 0.02, 1.4, -0.6)},
      {"pincushion", lens(width, height, -0.03, 0.9, 0.5)},
      {"ten degrees", lens(width, height, 0.17, 1, 0)},
      {"twenty degrees back", lens(width, height, -0.35, 1, 0)},
      {"a quarter", lens(width, height, M_PI / 2, 1, 0)},
      {"upside down", lens(width, height, M_PI, 1, 0)},
      {"enlarged", lens(width, height, 0.1, 0.3, 0)},
      {"reduced", lens(width, height, 0.1, 1.8, 0)},
      {"much reduced", lens(width, height, 0, 3.5, 0)},
      {"shaken",
       [=](int x, int y) {
         return std::pair{x + noise(3) - 1.5, y + noise(3) - 1.5};
       }},
      {"random",
       [=](int, int) {
         return std::pair{noise(width + 4) - 2, noise(height + 4) - 2};
       }},
  };
}

inline const std::vector<std::pair<int, int>> raw_sizes = {{1, 1},  {1, 7},  {7, 1},  {15, 9}, {16, 1},   {16, 2},  {16, 3},
                                                           {17, 4}, {24, 5}, {33, 6}, {80, 8}, {131, 40}, {200, 90}};

}  // namespace vdisp::kernels
