// comparison_page.cpp: rows of three: as it is, as it would be, what differs.
// SPDX-License-Identifier: Apache-2.0
#include "probe/comparison_page.h"

#include <algorithm>
#include <cstring>

#include "ipc/records.h"
#include "probe/format.h"
#include "probe/readout.h"

namespace vdisp {
namespace {

constexpr int gap = 12, line = 20;

void draw_image(Picture& page, Box room, const std::string& topic, const Image& image, PaintStyle style) {
  page.fill(room, colours::panel);
  if (image.spec.pixel == Pixel::record) {
    int y = room.y + 8;
    for (const std::string& record_line : record_text(image)) {
      if (y + line > room.y + room.height) break;
      page.text(room.x + 8, y, record_line.substr(0, static_cast<size_t>(std::max(room.width - 16, 0)) / Picture::letter_width),
                colours::text);
      y += line;
    }
    return;
  }
  if (!image.valid()) return draw_banner(page, room, "BLIND", describe(image.reason), colours::warning);
  style.map_room_width = room.width;
  style.map_room_height = room.height;
  const Picture picture = paint(topic, image, style).picture;
  page.draw(picture, fitted(picture.width(), picture.height(), room));
}

/// White where a pixel is another one.
Picture difference(const Image& before, const Image& after) {
  const uint32_t bytes = pixel_bytes(before.spec.pixel);
  Picture picture(before.spec.width, before.spec.height, {40, 44, 52});
  for (int y = 0; y < before.spec.height; ++y) {
    const std::byte *one = before.row<std::byte>(y), *other = after.row<std::byte>(y);
    for (int x = 0; x < before.spec.width; ++x)
      if (std::memcmp(one + x * bytes, other + x * bytes, bytes) != 0) picture.row(y)[x] = {255, 255, 255};
  }
  return picture;
}

}  // namespace

std::string difference_words(const ComparedStage& stage) {
  if (!stage.comparable()) {
    if (stage.before.image().spec != stage.after.image().spec) return "of another size";
    return stage.before.image().valid() == stage.after.image().valid() ? "both blind" : "one of them is blind";
  }
  if (stage.before.image().spec.pixel == Pixel::record) return stage.differing ? "differs" : "the same";
  const std::string differing = format("%llu of %llu px differ (%.1f %%)", static_cast<unsigned long long>(stage.differing),
                                       static_cast<unsigned long long>(stage.pixels),
                                       100.0 * static_cast<double>(stage.differing) / static_cast<double>(stage.pixels));
  if (!*stage.count.what) return differing;
  return differing + format("; %llu -> %llu %s", static_cast<unsigned long long>(stage.count.before),
                            static_cast<unsigned long long>(stage.count.after), stage.count.what);
}

std::vector<const ComparedStage*> chosen_stages(const Comparison& comparison, const std::vector<std::string>& wanted) {
  std::vector<const ComparedStage*> chosen;
  const auto find = [&](const std::string& topic) {
    const auto found =
        std::find_if(comparison.stages.begin(), comparison.stages.end(), [&](const ComparedStage& stage) { return stage.topic == topic; });
    return found == comparison.stages.end() ? nullptr : &*found;
  };
  for (const std::string& topic : wanted) {
    if (!find(topic)) {
      std::string all;
      for (const ComparedStage& stage : comparison.stages) all += " " + stage.topic;
      throw ProbeError(64, "there is no stage '" + topic + "' to be compared; there are" + all);
    }
    chosen.push_back(find(topic));
  }
  if (!chosen.empty()) return chosen;
  for (const char* topic : {"disparity", "surface", "obstacles", "occupancy", "map", "show_scene"})
    if (const ComparedStage* stage = find(topic); stage && chosen.size() < 4) chosen.push_back(stage);
  return chosen;
}

Picture comparison_page(const Comparison& comparison, const std::vector<const ComparedStage*>& stages, int width) {
  const int tile = std::max((width - 4 * gap) / 3, 16), tile_height = tile * 3 / 4;
  const auto changes = static_cast<int>(comparison.changes.size());
  const int top = gap + (changes + 1) * line + gap, row_height = line + tile_height + gap;
  Picture page(width, top + static_cast<int>(stages.size()) * row_height, colours::background);
  for (int i = 0; i < changes; ++i) page.text(gap, gap + i * line, comparison.changes[static_cast<size_t>(i)], colours::accent);
  const int head = gap + changes * line;
  page.text(gap, head, format("now, frame %llu", static_cast<unsigned long long>(comparison.last)), colours::dim);
  page.text(gap + tile + gap, head, "with the change, same frame", colours::dim);
  page.text(gap + 2 * (tile + gap), head, "where they differ", colours::dim);
  PaintStyle style;
  style.picture_rows = comparison.picture_rows;
  int y = top;
  for (const ComparedStage* stage : stages) {
    page.text(gap, y, stage->topic, colours::text);
    page.text(gap + Picture::text_width(stage->topic) + 12, y, difference_words(*stage), colours::dim);
    const auto room = [&](int column) { return Box{gap + column * (tile + gap), y + line, tile, tile_height}; };
    draw_image(page, room(0), stage->topic, stage->before.image(), style);
    draw_image(page, room(1), stage->topic, stage->after.image(), style);
    page.fill(room(2), colours::panel);
    if (stage->comparable() && stage->before.image().spec.pixel != Pixel::record) {
      const Picture picture = difference(stage->before.image(), stage->after.image());
      page.draw(picture, fitted(picture.width(), picture.height(), room(2)));
    }
    y += row_height;
  }
  return page;
}

}  // namespace vdisp
