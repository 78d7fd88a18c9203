// screen.cpp: the layout of the window. Nothing overlaps but what is asked for: help, and the words of a blind stage.
// SPDX-License-Identifier: Apache-2.0
#include "probe/view/screen.h"

#include <algorithm>
#include <array>
#include <cstdio>

#include "probe/attach.h"
#include "probe/format.h"
#include "probe/readout.h"
#include "probe/tree.h"

namespace vdisp {
namespace {

constexpr int bar_height = 30, foot_height = 26, tree_width = 296, margin = 10;

struct Chip {
  std::string text;
  Colour colour;
};

Chip chip_of(const ScreenState& state) {
  if (state.frozen) return {"FROZEN", colours::accent};
  switch (state.trust) {
    case Trust::fresh: return {"FRESH", colours::good};
    case Trust::blind: return {"BLIND", colours::warning};
    case Trust::stale: return {"STALE", colours::warning};
    case Trust::dead: return {"NO DAEMON", colours::bad};
  }
  return {"?", colours::bad};
}

const CatalogueEntry* shown_entry(const ScreenState& state) {
  return state.shown >= 0 && state.shown < static_cast<int>(state.entries.size()) ? &state.entries[state.shown] : nullptr;
}

void draw_bar(Picture& page, const ScreenState& state) {
  page.fill({0, 0, page.width(), bar_height}, colours::panel);
  const Chip chip = chip_of(state);
  const int chip_width = Picture::text_width(chip.text) + 16;
  page.fill({margin, 6, chip_width, bar_height - 12}, chip.colour);
  page.text(margin + 8, 7, chip.text, colours::background);
  int x = margin + chip_width + 14;
  const auto add_chip = [&](const std::string& text, Colour colour) {
    if (text.empty()) return;
    const int width = Picture::text_width(text) + 16;
    page.fill({x, 6, width, bar_height - 12}, colour);
    page.text(x + 8, 7, text, colours::background);
    x += width + 8;
  };
  add_chip(state.recording, colours::bad);
  add_chip(state.drive, colours::accent);
  char right[96] = "";
  if (state.image) {
    const char* synthetic = state.image->flags & flag_synthetic ? "synthetic  " : "";
    const auto frame = static_cast<unsigned long long>(state.image->sequence);
    const bool present = state.trust != Trust::dead && !state.frozen;
    if (present) {
      const double age_ms = std::min(1000 * state.age_s, 99999.0);
      std::snprintf(right, sizeof right, "%sframe %llu  %4.0f Hz  %5.0f ms old", synthetic, frame, state.rate, age_ms);
    } else {
      std::snprintf(right, sizeof right, "%sframe %llu", synthetic, frame);
    }
  }
  const int right_x = page.width() - Picture::text_width(right) - margin;
  if (const CatalogueEntry* entry = shown_entry(state)) {
    const std::string topic(name_of(*entry)), spec = spec_words(entry->spec);
    page.text(x, 7, topic, colours::text);
    x += Picture::text_width(topic) + 14;
    if (x + Picture::text_width(spec) < right_x) page.text(x, 7, spec, colours::dim);
    x += Picture::text_width(spec) + 14;
  }
  if (x < right_x) page.text(right_x, 7, right, colours::dim);
}

// The letters of a branch as strokes: "|-" a fork, "`-" the last one, "| " passing by.
void draw_branch(Picture& page, int x, int y, std::string_view branch) {
  constexpr Colour ink{98, 106, 118};
  for (size_t i = 0; i + 1 < branch.size(); i += 2, x += 2 * Picture::letter_width) {
    if (branch[i] != ' ') page.fill({x + 4, y - 2, 1, branch[i] == '`' ? 10 : 20}, ink);
    if (branch[i + 1] == '-') page.fill({x + 4, y + 8, 9, 1}, ink);
  }
}

void draw_tree(Picture& page, Box room, const ScreenState& state) {
  page.fill(room, colours::panel);
  page.text(room.x + margin, room.y + 8, "stage", colours::dim);
  const int end = room.x + room.width - margin;
  page.text(end - Picture::text_width("last ms"), room.y + 8, "last ms", colours::dim);
  int y = room.y + 34;
  for (const TreeLine& line : tree_of(state.entries, true)) {
    if (y + 20 > room.y + room.height) return;
    const CatalogueEntry& entry = state.entries[line.entry];
    const bool here = static_cast<int>(line.entry) == state.shown;
    if (here) page.fill({room.x, y - 2, room.width, 20}, {44, 66, 92});
    const int name_x = room.x + margin + Picture::text_width(line.branch);
    draw_branch(page, room.x + margin, y, line.branch);
    page.text(name_x, y, name_of(entry), here || entry.watched ? colours::text : colours::dim);
    char time[24] = "-";
    if (entry.runs) std::snprintf(time, sizeof time, "%.2f", static_cast<double>(entry.last_ns) / 1e6);
    const int time_x = end - Picture::text_width(time);
    if (time_x > name_x + Picture::text_width(name_of(entry))) page.text(time_x, y, time, here ? colours::text : colours::dim);
    y += 20;
  }
}

void draw_record(Picture& page, Box room, const Image& image) {
  int y = room.y + 16;
  for (const std::string& record_line : record_text(image)) {
    for (const std::string& line : wrapped(record_line, static_cast<size_t>(std::max(room.width - 32, 80)) / Picture::letter_width)) {
      if (y + Picture::letter_height > room.y + room.height) return;
      page.text(room.x + 16, y, line, colours::text);
      y += 24;
    }
  }
}

void draw_state(Picture& page, Box room, const ScreenState& state) {
  if (state.frozen || (state.trust == Trust::fresh && state.image)) return;
  page.blend(room, colours::background, 150);
  char detail[96];
  switch (state.trust) {
    case Trust::fresh: return draw_banner(page, room, "WAITING", "for the first image of this stage", colours::accent);
    case Trust::blind: return draw_banner(page, room, "BLIND", describe(state.reason), colours::warning);
    case Trust::stale:
      if (!state.image) return draw_banner(page, room, "WAITING", "for the first image of this stage", colours::accent);
      std::snprintf(detail, sizeof detail, "the last image is %.1f s old", state.age_s);
      return draw_banner(page, room, "STALE", detail, colours::warning);
    case Trust::dead: return draw_banner(page, room, "NO DAEMON, WAITING", state.trouble, colours::bad);
  }
}

void draw_help(Picture& page, Box room, bool drives) {
  std::vector<std::array<const char*, 2>> lines{{"Down, left click", "next stage"},
                                                {"Up, right click", "previous stage"},
                                                {"Left, Right, wheel", "image of the stage"},
                                                {"p", "sliders of the stage's parameters"},
                                                {"Tab, + -, drag", "choose one, and change it"}};
  if (drives)
    lines = {{"Up, Left, Right", "held: ahead, turn"},
             {"Down", "held: stand"},
             {"mouse button", "turns while held, then ahead"},
             {"middle, leave", "ends driving by mouse"},
             {"gamepad", "left stick or cross"},
             {"Page Up, Down", "stage"},
             {"Tab, wheel", "image of the stage"},
             {"p, + -", "sliders, and change one"}};
  static constexpr std::array<const char*, 2> others[] = {{"u, w", "undo; write to vdisp.cfg"},
                                                          {"a", "sliders of this stage, or all"},
                                                          {"c", "next colour map"},
                                                          {"s", "save the picture as PNG"},
                                                          {"space", "freeze, and go on"},
                                                          {"t", "tree of the stages"},
                                                          {"?", "this help"},
                                                          {"q, Esc", "quit"}};
  lines.insert(lines.end(), std::begin(others), std::end(others));
  const int height = static_cast<int>(std::size(lines)) * 22 + 24, width = 420;
  const Box box{room.x + (room.width - width) / 2, room.y + (room.height - height) / 2, width, height};
  page.blend(box, {10, 11, 14}, 235);
  page.frame(box, colours::accent);
  for (size_t i = 0; i < std::size(lines); ++i) {
    const int y = box.y + 14 + static_cast<int>(i) * 22;
    page.text(box.x + 20, y, lines[i][0], colours::accent);
    page.text(box.x + 200, y, lines[i][1], colours::text);
  }
}

/// Draws the stage and tells what lies under the cursor.
std::string draw_stage(Picture& page, Box room, const ScreenState& state) {
  const Image& image = *state.image;
  if (image.spec.pixel == Pixel::record) {
    draw_record(page, room, image);
    return {};
  }
  const std::string topic(shown_entry(state) ? name_of(*shown_entry(state)) : "");
  PaintStyle style = state.style;
  style.map_room_width = room.width;
  style.map_room_height = room.height;
  const Painted painted = paint(topic, image, style);
  const Picture& picture = painted.picture;
  const Box box = painted.cell > 1 ? Box{room.x + (room.width - picture.width()) / 2, room.y + (room.height - picture.height()) / 2,
                                         picture.width(), picture.height()}
                                   : fitted(picture.width(), picture.height(), room);
  page.draw(picture, box);
  const int x = state.mouse_x - box.x, y = state.mouse_y - box.y;
  if (x < 0 || y < 0 || x >= box.width || y >= box.height) return {};
  const int column = x * picture.width() / box.width / painted.cell, row = y * picture.height() / box.height / painted.cell;
  const std::string here = read_out(topic, image, column, row);
  const Image* height = state.height;
  const bool beside = height && topic != "height" && !here.empty() && height->spec.pixel == Pixel::height16 &&
                      height->spec.width == image.spec.width && height->spec.height == image.spec.height;
  if (!beside) return here;
  const int16_t mm = height->row<int16_t>(row)[column];
  return here + (mm == height_unknown ? std::string("  height unknown") : format("  %+.2f m over the floor", mm / 1000.0));
}

}  // namespace

Box panel_room(int width, int height) {
  const int panel_width = width >= 2 * tree_width ? tree_width : 0;
  return {width - panel_width, bar_height, panel_width, std::max(height - foot_height - bar_height, 0)};
}

Picture draw_screen(const ScreenState& state, int width, int height) {
  Picture page(width, height, colours::background);
  draw_bar(page, state);
  const bool panel = state.panel.open && panel_room(width, height).width > 0;
  const bool tree = (state.tree || panel) && width >= 2 * tree_width;
  const int stage_width = width - (tree ? tree_width : 0), end = height - foot_height;
  if (panel) draw_panel(page, panel_room(width, height), state.panel);
  if (tree && !panel) draw_tree(page, {stage_width, bar_height, tree_width, end - bar_height}, state);

  std::vector<LegendItem> items;
  if (state.image && shown_entry(state)) items = legend(name_of(*shown_entry(state)), *state.image, state.style);
  const int below = legend_height(items, stage_width - 2 * margin);
  const Box room{0, bar_height + 2, stage_width, std::max(end - bar_height - below - (below ? 8 : 4), 16)};
  std::string value;
  if (state.image) value = draw_stage(page, room, state);
  draw_state(page, room, state);
  draw_legend(page, {margin, end - below - 2, stage_width - 2 * margin, below}, items);

  page.fill({0, end, width, foot_height}, colours::panel);
  const std::string keys = std::string("c ") + std::string(name(state.style.palette)) + "   ? keys";
  page.text(width - Picture::text_width(keys) - margin, end + 5, keys, colours::dim);
  const size_t fits = static_cast<size_t>(std::max(0, width - Picture::text_width(keys) - 3 * margin) / Picture::letter_width);
  const bool told = !state.message.empty();
  const bool picture = state.image && state.image->spec.pixel != Pixel::record;
  const std::string hint = picture ? "point at the picture for its values" : "";
  const std::string line = told ? state.message : value.empty() ? hint : value;
  page.text(margin, end + 5, line.substr(0, fits), told ? colours::accent : value.empty() ? colours::dim : colours::text);
  if (state.help) draw_help(page, {0, bar_height, width, end - bar_height}, state.drives);
  return page;
}

}  // namespace vdisp
