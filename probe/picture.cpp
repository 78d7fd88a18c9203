// picture.cpp: boxes, lines, text and scaling on a plain array of pixels.
// SPDX-License-Identifier: Apache-2.0
#include "probe/picture.h"

#include <algorithm>
#include <cmath>

namespace vdisp {
namespace {

constexpr int outside = 1'000'000;  // no picture reaches so far, and sums of such numbers fit

uint8_t mixed(int below, int above, int weight) { return static_cast<uint8_t>((below * (256 - weight) + above * weight) >> 8); }

void blend_pixel(Colour& pixel, Colour colour, int weight) {
  pixel = {mixed(pixel.r, colour.r, weight), mixed(pixel.g, colour.g, weight), mixed(pixel.b, colour.b, weight)};
}

/// Opacity 0..15 of a letter enlarged `size` times: between its pixels interpolated, with edges as sharp as the small one's.
int enlarged(char letter, int x, int y, int size) {
  if (size == 1) return letter_pixel(letter, x, y);
  const auto pixel = [&](int u, int v) {
    return u < 0 || v < 0 || u >= Picture::letter_width || v >= Picture::letter_height ? 0 : letter_pixel(letter, u, v);
  };
  const double u = (x + 0.5) / size - 0.5, v = (y + 0.5) / size - 0.5;
  const int u0 = static_cast<int>(std::floor(u)), v0 = static_cast<int>(std::floor(v));
  const double du = u - u0, dv = v - v0;
  const double mixed =
      (pixel(u0, v0) * (1 - du) + pixel(u0 + 1, v0) * du) * (1 - dv) + (pixel(u0, v0 + 1) * (1 - du) + pixel(u0 + 1, v0 + 1) * du) * dv;
  return static_cast<int>(std::clamp((mixed - 6.5) * size + 7.5, 0.0, 15.0));
}

Colour mean(const Picture& picture, int x0, int x1, int y0, int y1) {
  uint32_t r = 0, g = 0, b = 0, count = 0;
  for (int y = y0; y < y1; ++y) {
    const Colour* row = picture.row(y);
    for (int x = x0; x < x1; ++x, ++count) r += row[x].r, g += row[x].g, b += row[x].b;
  }
  return {static_cast<uint8_t>(r / count), static_cast<uint8_t>(g / count), static_cast<uint8_t>(b / count)};
}

}  // namespace

Picture::Picture(int width, int height, Colour colour)
    : width_(std::max(width, 0)), height_(std::max(height, 0)), pixels_(static_cast<size_t>(width_) * height_, colour) {}

void Picture::fill(Box box, Colour colour) {
  const int x0 = std::max(box.x, 0), x1 = std::min(box.x + box.width, width_);
  const int y0 = std::max(box.y, 0), y1 = std::min(box.y + box.height, height_);
  for (int y = y0; y < y1 && x0 < x1; ++y) std::fill(row(y) + x0, row(y) + x1, colour);
}

void Picture::blend(Box box, Colour colour, int weight) {
  const int x0 = std::max(box.x, 0), x1 = std::min(box.x + box.width, width_);
  const int y0 = std::max(box.y, 0), y1 = std::min(box.y + box.height, height_);
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) blend_pixel(row(y)[x], colour, weight);
  }
}

void Picture::frame(Box box, Colour colour) {
  fill({box.x, box.y, box.width, 1}, colour);
  fill({box.x, box.y + box.height - 1, box.width, 1}, colour);
  fill({box.x, box.y, 1, box.height}, colour);
  fill({box.x + box.width - 1, box.y, 1, box.height}, colour);
}

int pixel_at(double place) { return std::abs(place) < outside ? static_cast<int>(std::floor(place)) : -outside; }

void Picture::line(double x0, double y0, double x1, double y1, Colour colour) {
  const double length = std::max(std::abs(x1 - x0), std::abs(y1 - y0));
  if (!(length < 1e5) || !(std::abs(x0) < outside) || !(std::abs(y0) < outside)) return;  // also not a number
  const int steps = std::max(1, static_cast<int>(std::ceil(length)));
  for (int i = 0; i <= steps; ++i) {
    const int x = pixel_at(x0 + (x1 - x0) * i / steps), y = pixel_at(y0 + (y1 - y0) * i / steps);
    if (x >= 0 && x < width_ && y >= 0 && y < height_) row(y)[x] = colour;
  }
}

void Picture::text(int x0, int y0, std::string_view text, Colour colour, int size) {
  for (char letter : text) {
    if (x0 >= width_) return;
    for (int y = 0; y < letter_height * size; ++y) {
      for (int x = 0; x < letter_width * size; ++x) {
        if (const int opacity = enlarged(letter, x, y, size)) blend({x0 + x, y0 + y, 1, 1}, colour, opacity * 17 + 1);
      }
    }
    x0 += letter_width * size;
  }
}

void Picture::draw(const Picture& other, Box box) {
  if (other.width_ == 0 || other.height_ == 0 || box.width <= 0 || box.height <= 0) return;
  const auto source = [](int i, int from, int to) { return static_cast<int>(static_cast<int64_t>(i) * from / to); };
  const bool shrunk = box.width < other.width_ || box.height < other.height_;
  std::vector<int> columns(box.width + 1);
  for (int x = 0; x <= box.width; ++x) columns[x] = source(x, other.width_, box.width);
  for (int y = std::max(0, -box.y); y < box.height && box.y + y < height_; ++y) {
    const int y0 = source(y, other.height_, box.height), y1 = std::max(y0 + 1, source(y + 1, other.height_, box.height));
    Colour* to = row(box.y + y);
    for (int x = std::max(0, -box.x); x < box.width && box.x + x < width_; ++x) {
      to[box.x + x] = shrunk ? mean(other, columns[x], std::max(columns[x] + 1, columns[x + 1]), y0, y1) : other.row(y0)[columns[x]];
    }
  }
}

Box fitted(int width, int height, Box room) {
  if (width <= 0 || height <= 0) return {room.x, room.y, 0, 0};
  const double scale = std::min(static_cast<double>(room.width) / width, static_cast<double>(room.height) / height);
  const int w = std::max(1, static_cast<int>(width * scale)), h = std::max(1, static_cast<int>(height * scale));
  return {room.x + (room.width - w) / 2, room.y + (room.height - h) / 2, w, h};
}

}  // namespace vdisp
