// panel.cpp: a row for each slider: key, value, bar; below them what the chosen one does.
// SPDX-License-Identifier: Apache-2.0
#include "probe/view/panel.h"

#include <algorithm>
#include <cmath>

#include "probe/paint.h"

namespace vdisp {
namespace {

constexpr int margin = 10, head = 30, row_height = 38, line = 18, help_lines = 9;

/// How many rows fit above the help.
int rows_in(Box room) { return std::max((room.height - head - help_lines * line) / row_height, 1); }

/// The chosen one is always in view.
size_t first_row(Box room, const Panel& panel) {
  const auto rows = static_cast<size_t>(rows_in(room));
  return panel.chosen < rows ? 0 : panel.chosen - rows + 1;
}

void draw_row(Picture& page, Box row, const Slider& slider, bool chosen) {
  if (chosen) page.fill(row, {44, 66, 92});
  const std::string value = slider.words();
  page.text(row.x + margin, row.y + 2, slider.key(), chosen ? colours::text : colours::dim);
  page.text(row.x + row.width - margin - Picture::text_width(value), row.y + 2, value, colours::text);
  const Box bar{row.x + margin, row.y + 24, row.width - 2 * margin, 6};
  page.fill(bar, {62, 68, 78});
  const std::optional<double> place = slider.place();
  if (!place) return;
  const int x = static_cast<int>(std::lround(*place * bar.width));
  page.fill({bar.x, bar.y, x, bar.height}, chosen ? colours::accent : colours::dim);
  page.fill({bar.x + std::clamp(x - 3, 0, std::max(bar.width - 6, 0)), bar.y - 4, 6, bar.height + 8},
            chosen ? colours::text : colours::dim);
}

/// Range, default and help of the chosen one; what was refused goes before them.
void draw_help(Picture& page, Box room, const Panel& panel) {
  page.fill({room.x + margin, room.y, room.width - 2 * margin, 1}, {62, 68, 78});
  std::vector<std::string> texts;
  if (panel.chosen < panel.sliders.size()) {
    const ParameterInfo& info = panel.sliders[panel.chosen].info();
    texts = {info.allowed + ", default " + info.standard, info.help};
  }
  if (!panel.trouble.empty()) texts.insert(texts.begin(), panel.trouble);
  int y = room.y + 6;
  for (const std::string& text : texts) {
    const Colour colour = &text == &texts.front() && !panel.trouble.empty() ? colours::warning
                          : &text == &texts.back()                          ? colours::text
                                                                            : colours::dim;
    for (const std::string& words : wrapped(text, static_cast<size_t>(std::max(room.width - 2 * margin, 80)) / Picture::letter_width)) {
      if (y + line > room.y + room.height) return;
      page.text(room.x + margin, y, words, colour);
      y += line;
    }
  }
}

}  // namespace

void draw_panel(Picture& page, Box room, const Panel& panel) {
  page.fill(room, colours::panel);
  page.text(room.x + margin, room.y + 8, panel.everything ? "all live parameters" : "parameters", colours::dim);
  const std::string keys = "Tab + - u w a";
  page.text(room.x + room.width - margin - Picture::text_width(keys), room.y + 8, keys, colours::dim);
  const size_t first = first_row(room, panel), end = std::min(panel.sliders.size(), first + static_cast<size_t>(rows_in(room)));
  for (size_t i = first; i < end; ++i)
    draw_row(page, {room.x, room.y + head + static_cast<int>(i - first) * row_height, room.width, row_height - 2}, panel.sliders[i],
             i == panel.chosen);
  if (panel.sliders.empty() && panel.trouble.empty())
    page.text(room.x + margin, room.y + head, panel.waits ? "the daemon is asked" : "this stage has none; a: all", colours::dim);
  const int below = room.y + head + static_cast<int>(end - first) * row_height + 4;
  draw_help(page, {room.x, below, room.width, room.y + room.height - below}, panel);
}

std::optional<PanelHit> hit(Box room, const Panel& panel, int x, int y) {
  if (x < room.x || x >= room.x + room.width || y < room.y + head) return std::nullopt;
  const int row = (y - room.y - head) / row_height;
  const size_t index = first_row(room, panel) + static_cast<size_t>(row);
  if (row >= rows_in(room) || index >= panel.sliders.size()) return std::nullopt;
  return PanelHit{index, place_along(room, x)};
}

double place_along(Box room, int x) {
  return std::clamp(static_cast<double>(x - room.x - margin) / std::max(room.width - 2 * margin, 1), 0.0, 1.0);
}

}  // namespace vdisp
