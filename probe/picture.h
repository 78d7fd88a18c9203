// picture.h: a colour picture in memory with the few strokes the probe needs: boxes, lines, text, scaled pictures.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

namespace vdisp {

struct Colour {
  uint8_t r = 0, g = 0, b = 0;
  bool operator==(const Colour&) const = default;
};

struct Box {
  int x = 0, y = 0, width = 0, height = 0;
};

/// The pixel at a place, which may be any number: what is too far for a picture, or no number, is far outside of every one.
int pixel_at(double place);

/// Everything drawn is clipped to the picture. Rows are packed, three bytes a pixel.
class Picture {
 public:
  Picture() = default;
  Picture(int width, int height, Colour colour = {});

  int width() const { return width_; }
  int height() const { return height_; }
  Colour* row(int y) { return pixels_.data() + static_cast<size_t>(y) * width_; }
  const Colour* row(int y) const { return pixels_.data() + static_cast<size_t>(y) * width_; }

  void fill(Box box, Colour colour);
  /// `weight` of 256 parts of the colour over what is there.
  void blend(Box box, Colour colour, int weight);
  void frame(Box box, Colour colour);
  void line(double x0, double y0, double x1, double y1, Colour colour);
  /// Top left corner at (x, y); ASCII, other bytes show as '?'.
  void text(int x, int y, std::string_view text, Colour colour, int size = 1);
  /// Another picture, scaled into the box: single pixels stay sharp when enlarged, and are averaged when shrunk.
  void draw(const Picture& other, Box box);

  static constexpr int letter_width = 8, letter_height = 16;
  static int text_width(std::string_view text, int size = 1) { return static_cast<int>(text.size()) * letter_width * size; }

 private:
  int width_ = 0, height_ = 0;
  std::vector<Colour> pixels_;
};

/// The largest box of the proportions width:height in the middle of `room`.
Box fitted(int width, int height, Box room);

/// Opacity 0..15 of a letter's pixel, 0 <= x < letter_width, 0 <= y < letter_height.
int letter_pixel(char letter, int x, int y);

}  // namespace vdisp
