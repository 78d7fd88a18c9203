// paint.h: one image of the tree as a colour picture, on scales that do not change from frame to frame.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "ipc/image.h"
#include "probe/picture.h"

namespace vdisp {

enum class Palette { turbo, viridis, gray };
inline constexpr int palettes = 3;
std::string_view name(Palette palette);
/// The colour at 0..1; outside it the nearest end's.
Colour colour_of(Palette palette, double value);
/// The muted colour of pixels that were rejected with this code.
Colour rejected_colour(uint8_t code);
/// The colour of what a cell or a pixel is; codes that this version does not know have one of their own.
Colour reason_colour(uint8_t cell_reason);
Colour surface_colour(uint8_t surface);
Colour true_cell_colour(uint8_t true_cell);
/// The colour of a cell of `occupancy`: from occupied_from on no shade of what is less.
Colour occupancy_colour(int8_t percent);

struct PaintStyle {
  Palette palette = Palette::turbo;
  int map_room_width = 612, map_room_height = 600;  ///< px into which a map is drawn, in whole pixels per cell
  int picture_rows = 0;                             ///< height of the camera's images, for lines; 0: guessed from cy
};

/// A picture and where the image's pixels lie in it: column c covers cell px from c * cell on.
struct Painted {
  Picture picture;
  int cell = 1;
};

/// Draws a picture stage; the image must be valid and no record.
Painted paint(std::string_view topic, const Image& image, const PaintStyle& style);

/// One entry of a legend: a ramp of colours from `from` to `to`, or one colour and what it means.
struct LegendItem {
  std::vector<Colour> colours;
  std::string from, to;
};
std::vector<LegendItem> legend(std::string_view topic, const Image& image, const PaintStyle& style);
/// Height of the legend when broken into lines of this width; 0 for none.
int legend_height(const std::vector<LegendItem>& items, int width);
void draw_legend(Picture& picture, Box box, const std::vector<LegendItem>& items);

/// The picture with its legend below; of a blind image its reason, of a record its text. What files and contact sheets show.
Picture portrait(std::string_view topic, const Image& image, const PaintStyle& style);

/// Large words over a darkened picture: BLIND, STALE, DEAD.
void draw_banner(Picture& picture, Box box, std::string_view title, std::string_view detail, Colour colour);
/// Words broken into lines of at most `columns` letters.
std::vector<std::string> wrapped(std::string_view text, size_t columns);

namespace colours {
inline constexpr Colour background{18, 20, 24}, panel{28, 31, 37}, text{222, 226, 232}, dim{132, 140, 152}, accent{94, 176, 255};
inline constexpr Colour good{92, 200, 120}, warning{240, 184, 64}, bad{236, 92, 84};
}  // namespace colours

}  // namespace vdisp
