// contact_sheet.cpp: tiles of one size, four in a row.
// SPDX-License-Identifier: Apache-2.0
#include "probe/contact_sheet.h"

#include <algorithm>

#include "ipc/records.h"
#include "probe/readout.h"

namespace vdisp {
namespace {

constexpr int tile_width = 360, tile_height = 270, title_height = 24, gap = 12, across = 4;

void draw_tile(Picture& page, Box room, const SheetEntry& entry, PaintStyle style) {
  const Image& image = *entry.image;
  page.text(room.x, room.y + 4, entry.topic, colours::text);
  page.text(room.x + Picture::text_width(entry.topic) + 12, room.y + 4, spec_words(image.spec), colours::dim);
  room = {room.x, room.y + title_height, tile_width, tile_height};
  page.fill(room, colours::panel);
  if (image.spec.pixel == Pixel::record) {
    int y = room.y + 8;
    for (const std::string& line : record_text(image)) {
      if (y + Picture::letter_height > room.y + room.height) break;
      page.text(room.x + 8, y, line.substr(0, (tile_width - 16) / Picture::letter_width), colours::text);
      y += Picture::letter_height;
    }
  } else if (!image.valid()) {
    draw_banner(page, room, "BLIND", describe(image.reason), colours::warning);
  } else {
    style.map_room_width = tile_width;
    style.map_room_height = tile_height;
    const Picture picture = paint(entry.topic, image, style).picture;
    page.draw(picture, fitted(picture.width(), picture.height(), room));
  }
}

}  // namespace

Picture contact_sheet(const std::vector<SheetEntry>& entries, int picture_rows) {
  const int count = static_cast<int>(entries.size()), columns = std::clamp(count, 1, across);
  const int rows = (count + columns - 1) / columns;
  const int pitch_x = tile_width + gap, pitch_y = title_height + tile_height + gap;
  Picture page(gap + columns * pitch_x, gap + rows * pitch_y, colours::background);
  PaintStyle style;
  style.picture_rows = picture_rows;
  for (int i = 0; i < count; ++i) {
    const Box room{gap + i % columns * pitch_x, gap / 2 + i / columns * pitch_y, tile_width, title_height + tile_height};
    draw_tile(page, room, entries[static_cast<size_t>(i)], style);
  }
  return page;
}

}  // namespace vdisp
