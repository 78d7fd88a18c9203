// legend.cpp: what the colours of a picture mean, large words over it, and the picture with both as one.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>

#include "ipc/dump.h"
#include "ipc/records.h"
#include "probe/paint.h"
#include "probe/readout.h"
#include "probe/scales.h"

namespace vdisp {
namespace {

constexpr int line_height = 20, swatch = 12, ramp_width = 96, gap = 14;

LegendItem ramp(Palette palette, std::string from, std::string to) {
  LegendItem item{{}, std::move(from), std::move(to)};
  for (int i = 0; i < ramp_width; ++i) item.colours.push_back(colour_of(palette, i / (ramp_width - 1.0)));
  return item;
}

LegendItem one(Colour colour, std::string meaning) { return {{colour}, {}, std::move(meaning)}; }

int width_of(const LegendItem& item) {
  const bool is_ramp = item.colours.size() > 1;
  return (is_ramp ? Picture::text_width(item.from) + 6 + ramp_width : swatch) + 6 + Picture::text_width(item.to) + gap;
}

/// The codes that are in the image, each with its colour, its name and its share of the pixels.
template <class T, class Code, class ColourOf, class NameOf>
void add_codes(const Image& image, std::vector<LegendItem>& items, Code code_of, ColourOf colour, NameOf meaning) {
  int counts[256] = {};
  for (int y = 0; y < image.spec.height; ++y) {
    const T* row = image.row<T>(y);
    for (int x = 0; x < image.spec.width; ++x) ++counts[code_of(row[x])];
  }
  const double all = std::max(1, image.spec.width * image.spec.height);
  for (int i = 0; i < 256; ++i) {
    const auto code = static_cast<uint8_t>(i);
    const std::string words(meaning(code));
    if (counts[i] == 0 || words.empty()) continue;
    char percent[8];
    const double share = 100 * counts[i] / all;
    if (share < 1)
      std::snprintf(percent, sizeof percent, " <1%%");
    else
      std::snprintf(percent, sizeof percent, " %2.0f%%", share);
    items.push_back(one(colour(code), words + percent));
  }
}

void add_rejected(const Image& image, std::vector<LegendItem>& items) {
  add_codes<int16_t>(image, items, rejected_code, rejected_colour,
                     [](uint8_t code) { return code == 0 ? std::string_view() : name(Rejected{code}); });
}

LegendItem occupancy_ramp(const std::string& meaning, int from, int to) {
  LegendItem item{{}, meaning + " " + std::to_string(from), std::to_string(to) + " %"};
  for (int i = 0; i < ramp_width; ++i)
    item.colours.push_back(occupancy_colour(static_cast<int8_t>(from + (to - from) * i / (ramp_width - 1))));
  return item;
}

/// Calls put(item, x, y) for each item in lines of this width; returns the height.
template <class Put>
int flow(const std::vector<LegendItem>& items, int width, Put put) {
  if (items.empty()) return 0;
  int x = 0, y = 0;
  for (const LegendItem& item : items) {
    const int needed = width_of(item);
    if (x > 0 && x + needed - gap > width) x = 0, y += line_height;
    put(item, x, y);
    x += needed;
  }
  return y + line_height;
}

}  // namespace

std::vector<LegendItem> legend(std::string_view topic, const Image& image, const PaintStyle& style) {
  std::vector<LegendItem> items;
  if (!image.valid()) return items;
  switch (image.spec.pixel) {
    case Pixel::disparity16: {
      const DisparityScale scale = disparity_scale(image.camera);
      items.push_back(ramp(style.palette, std::to_string(scale.from), std::to_string(scale.to) + " px"));
      add_rejected(image, items);
      break;
    }
    case Pixel::count16:
      if (is_depth_map(topic)) {
        items.push_back(ramp(style.palette, "1", std::to_string(votes_scale) + " pixels of the column, logarithmic"));
        items.push_back(one({12, 12, 16}, "none; near below, far above"));
      } else if (!is_grid(topic)) {
        items.push_back(ramp(style.palette, "1", std::to_string(votes_scale) + " votes, logarithmic"));
      } else {
        items.push_back(one({240, 110, 60}, "obstacle (" + std::to_string(image.grid.min_count) + " points or more)"));
        items.push_back(one({112, 84, 52}, "fewer points"));
        items.push_back(one({38, 52, 62}, "in view, nothing seen"));
      }
      break;
    case Pixel::height16:
      items.push_back(ramp(style.palette, "-0.5", "1.5 m over the floor"));
      items.push_back(one(colours::panel, "unknown"));
      break;
    case Pixel::int8:
      items.push_back(occupancy_ramp("free", 0, free_up_to));
      items.push_back(occupancy_ramp("suspected", free_up_to + 1, occupied_from - 1));
      items.push_back(occupancy_ramp("obstacle", occupied_from, 100));
      items.push_back(one(occupancy_colour(-1), "unknown"));
      break;
    case Pixel::gray8:
      if (is_reason(topic))
        add_codes<uint8_t>(
            image, items, [](uint8_t v) { return v; }, reason_colour, [](uint8_t v) { return name(CellReason{v}); });
      else if (is_surface(topic))
        add_codes<uint8_t>(
            image, items, [](uint8_t v) { return v; }, surface_colour, [](uint8_t v) { return name(Surface{v}); });
      else if (is_contour(topic, image)) {
        items.push_back(one({240, 110, 60}, "from the nearest obstacle of the column on; near below, far above"));
      } else if (is_features(topic)) {
        items.push_back(ramp(style.palette, "1", "255, logarithmic"));
        items.push_back(one({12, 12, 16}, "0"));
      } else if (is_census(topic))
        items.push_back(ramp(Palette::gray, "0", "255: a bit for each neighbour that is darker"));
      else if (is_true_cells(topic))
        add_codes<uint8_t>(
            image, items, [](uint8_t v) { return v; }, true_cell_colour, [](uint8_t v) { return name(TruthCell{v}); });
      break;
    case Pixel::rgb8:
      if (topic != "show_scene") break;
      items.push_back(one({60, 220, 90}, "free"));
      items.push_back(one({255, 60, 40}, "obstacle, drop-off"));
      items.push_back(one({200, 80, 255}, "below the floor"));
      items.push_back(one({255, 255, 255}, "floor every few metres"));
      items.push_back(one({80, 160, 255}, "limit over it"));
      items.push_back(one({255, 220, 60}, "horizon"));
      break;
    case Pixel::mask8: items.push_back(one({236, 92, 60}, "obstacle")); break;
    case Pixel::line16: items.push_back(one(colours::warning, "image row for each disparity")); break;
    default: break;
  }
  return items;
}

int legend_height(const std::vector<LegendItem>& items, int width) {
  return flow(items, width, [](const LegendItem&, int, int) {});
}

void draw_legend(Picture& picture, Box box, const std::vector<LegendItem>& items) {
  flow(items, box.width, [&](const LegendItem& item, int dx, int dy) {
    int x = box.x + dx;
    const int y = box.y + dy;
    if (item.colours.size() > 1) {
      picture.text(x, y + 2, item.from, colours::dim);
      x += Picture::text_width(item.from) + 6;
      for (size_t i = 0; i < item.colours.size(); ++i) picture.fill({x + static_cast<int>(i), y + 4, 1, swatch}, item.colours[i]);
      x += ramp_width + 6;
    } else {
      picture.fill({x, y + 4, swatch, swatch}, item.colours.at(0));
      picture.frame({x, y + 4, swatch, swatch}, colours::dim);
      x += swatch + 6;
    }
    picture.text(x, y + 2, item.to, colours::dim);
  });
}

std::vector<std::string> wrapped(std::string_view text, size_t columns) {
  std::vector<std::string> lines;
  columns = std::max<size_t>(columns, 1);
  while (text.size() > columns) {
    size_t end = text.rfind(' ', columns);
    if (end == std::string_view::npos || end == 0) end = columns;
    lines.emplace_back(text.substr(0, end));
    text.remove_prefix(std::min(text.size(), end + (end < text.size() && text[end] == ' ')));
  }
  if (!text.empty()) lines.emplace_back(text);
  return lines;
}

void draw_banner(Picture& picture, Box box, std::string_view title, std::string_view detail, Colour colour) {
  const int size = std::clamp(box.width / (2 * Picture::text_width(title) + 1), 1, 3);
  const auto lines = wrapped(detail, static_cast<size_t>(std::max(box.width - 40, 80)) / Picture::letter_width);
  const int height = Picture::letter_height * size + Picture::letter_height * static_cast<int>(lines.size()) + 24;
  const Box band{box.x, box.y + (box.height - height) / 2, box.width, height};
  picture.blend(band, {10, 11, 14}, 215);
  picture.fill({band.x, band.y, band.width, 2}, colour);
  picture.fill({band.x, band.y + band.height - 2, band.width, 2}, colour);
  const auto centred = [&](std::string_view text, int y, Colour ink, int scale) {
    picture.text(box.x + std::max(0, (box.width - Picture::text_width(text, scale)) / 2), y, text, ink, scale);
  };
  centred(title, band.y + 8, colour, size);
  int y = band.y + 12 + Picture::letter_height * size;
  for (const std::string& line : lines) {
    centred(line, y, colours::text, 1);
    y += Picture::letter_height;
  }
}

Picture portrait(std::string_view topic, const Image& image, const PaintStyle& style) {
  if (image.spec.pixel == Pixel::record) {
    const std::vector<std::string> lines = record_text(image);
    Picture picture(420, static_cast<int>(lines.size()) * 20 + 20, colours::panel);
    for (size_t i = 0; i < lines.size(); ++i) picture.text(14, 10 + static_cast<int>(i) * 20, lines[i], colours::text);
    return picture;
  }
  if (!image.valid()) {
    Picture picture(std::max<int>(image.spec.width, 320), std::max<int>(image.spec.height, 240), colours::panel);
    draw_banner(picture, {0, 0, picture.width(), picture.height()}, "BLIND", describe(image.reason), colours::warning);
    return picture;
  }
  const Painted painted = paint(topic, image, style);
  const auto items = legend(topic, image, style);
  const int width = painted.picture.width(), height = painted.picture.height(), below = legend_height(items, width - 16);
  Picture picture(width, height + (below ? below + 6 : 0), colours::panel);
  picture.draw(painted.picture, {0, 0, width, height});
  draw_legend(picture, {8, height + 3, width - 16, below}, items);
  return picture;
}

}  // namespace vdisp
