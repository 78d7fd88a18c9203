// map_text.cpp: cells to letters.
// SPDX-License-Identifier: Apache-2.0
#include "probe/map_text.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "probe/readout.h"

namespace vdisp {
namespace {

// In order of importance: where several cells share a letter, the greatest is shown.
enum Kind : uint8_t { hidden, seen, few, obstacle };

/// The map at the size it is shown: `height` is even, two rows to a line.
struct Kinds {
  int width = 0, height = 0;
  double scale = 1;  ///< shown cells per cell of the map
  std::vector<Kind> kinds;
  Kind at(int x, int y) const { return kinds[static_cast<size_t>(y) * width + x]; }
};

Kind kind_of(const Image& map, int x, int y) {
  const int16_t count = map.row<int16_t>(y)[x];
  if (is_obstacle(map.grid, count)) return obstacle;
  return count > 0 ? few : in_view(map.grid, x, y) ? seen : hidden;
}

double scale_for(const Image& map, const MapLook& look) {
  if (look.columns <= 0 || look.lines <= 0) return 1;
  const double fit = std::min(static_cast<double>(look.columns) / map.spec.width, 2.0 * look.lines / map.spec.height);
  return fit >= 1 ? std::floor(fit) : fit;
}

Kinds scaled(const Image& map, const MapLook& look) {
  Kinds out;
  out.scale = scale_for(map, look);
  out.width = std::max(1, static_cast<int>(map.spec.width * out.scale));
  const int rows = std::max(1, static_cast<int>(map.spec.height * out.scale));
  out.height = rows + rows % 2;
  out.kinds.assign(static_cast<size_t>(out.width) * out.height, hidden);
  for (int y = 0; y < map.spec.height; ++y) {
    // The last row stands at the bottom: an odd row too many is added at the far end.
    const int y0 = out.height - rows + y * rows / map.spec.height,
              y1 = out.height - rows + std::max((y + 1) * rows - 1, 0) / map.spec.height;
    for (int x = 0; x < map.spec.width; ++x) {
      const Kind kind = kind_of(map, x, y);
      const int x0 = x * out.width / map.spec.width, x1 = ((x + 1) * out.width - 1) / map.spec.width;
      for (int v = y0; v <= std::max(y0, y1); ++v) {
        for (int u = x0; u <= std::max(x0, x1); ++u) {
          Kind& shown = out.kinds[static_cast<size_t>(v) * out.width + u];
          shown = std::max(shown, kind);
        }
      }
    }
  }
  return out;
}

int ink(Kind kind, bool old) {
  constexpr int live[] = {233, 237, 94, 203}, grey[] = {233, 235, 238, 245};
  return old ? grey[kind] : live[kind];
}

/// One line of letters; colours are named only where they change, which keeps a slow ssh line fluent.
std::string letters_of(const Kinds& kinds, int line, const MapLook& look) {
  std::string text;
  int ink_before = -1, ground_before = -1;
  for (int x = 0; x < kinds.width; ++x) {
    const Kind upper = kinds.at(x, 2 * line), lower = kinds.at(x, 2 * line + 1), both = std::max(upper, lower);
    if (!look.colour) {
      text += " .+#"[both];
      continue;
    }
    const int top = ink(look.utf8 ? upper : both, look.old), ground = ink(look.utf8 ? lower : both, look.old);
    if (ground != ground_before) text += "\x1b[48;5;" + std::to_string(ground) + "m";
    ground_before = ground;
    if (top == ground) {
      text += ' ';
      continue;
    }
    if (top != ink_before) text += "\x1b[38;5;" + std::to_string(top) + "m";
    ink_before = top;
    text += "▀";
  }
  return look.colour ? text + "\x1b[0m" : text;
}

/// "3 m" beside the line in which this range begins, else nothing.
std::string range_label(const Image& map, const Kinds& kinds, int line) {
  const double cell = map.grid.cell, reach = map.spec.height * cell, step = reach > 12 ? (reach > 60 ? 20 : 5) : 1;
  if (!usable(map.grid)) return {};
  const auto ahead = [&](int row) { return static_cast<double>(map.grid.origin_row) * cell - row / kinds.scale * cell; };
  const auto rings = [&](int row) { return static_cast<int>(std::floor(ahead(row) / step + 1e-6)); };
  const int far_end = rings(2 * line), near_end = rings(2 * line + 2);
  if (far_end == near_end || far_end < 1) return {};
  return std::string(1, ' ').append(std::to_string(static_cast<int>(far_end * step))).append(" m");
}

}  // namespace

std::vector<std::string> map_text(const Image& map, const MapLook& look) {
  const Kinds kinds = scaled(map, look);
  std::vector<std::string> lines;
  for (int line = 0; line < kinds.height / 2; ++line) {
    lines.push_back(letters_of(kinds, line, look) + range_label(map, kinds, line));
  }
  const double origin = usable(map.grid) ? static_cast<double>(map.grid.origin_column) * kinds.scale : kinds.width / 2.0;
  const int camera = std::clamp(static_cast<int>(origin), 0, kinds.width - 1);
  lines.push_back(std::string(static_cast<size_t>(camera), ' ') + (look.colour ? "\x1b[38;5;75m^\x1b[0m" : "^") + " camera");
  return lines;
}

std::string nearest_words(const Image& map) {
  const std::optional<Place> nearest = nearest_obstacle(map);
  if (!nearest) return "no obstacle in the map";
  char text[96];
  const double bearing = nearest->bearing_deg();
  std::snprintf(text, sizeof text, "nearest obstacle %.2f m away, %.0f deg to the %s", nearest->distance(), std::abs(bearing),
                bearing < 0 ? "left" : "right");
  return text;
}

}  // namespace vdisp
