// paint.cpp: a colour for every kind of pixel; the map as a plan with ranges, lines as a curve.
// SPDX-License-Identifier: Apache-2.0
#include "probe/paint.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "ipc/dump.h"
#include "ipc/records.h"
#include "probe/readout.h"
#include "probe/scales.h"

namespace vdisp {
namespace {

using Stops = std::array<Colour, 9>;
constexpr Stops turbo{{{48, 18, 59},
                       {70, 107, 227},
                       {40, 187, 236},
                       {49, 242, 153},
                       {162, 252, 60},
                       {237, 208, 58},
                       {251, 128, 34},
                       {210, 49, 5},
                       {122, 4, 3}}};
constexpr Stops viridis{{{68, 1, 84},
                         {71, 45, 123},
                         {59, 82, 139},
                         {44, 114, 142},
                         {33, 145, 140},
                         {40, 174, 128},
                         {94, 201, 98},
                         {173, 220, 48},
                         {253, 231, 37}}};
constexpr Stops gray{{{24, 24, 24},
                      {53, 53, 53},
                      {82, 82, 82},
                      {111, 111, 111},
                      {140, 140, 140},
                      {169, 169, 169},
                      {198, 198, 198},
                      {227, 227, 227},
                      {255, 255, 255}}};
constexpr std::array<Colour, 8> labels{
    {{230, 159, 0}, {86, 180, 233}, {0, 158, 115}, {240, 228, 66}, {0, 114, 178}, {213, 94, 0}, {204, 121, 167}, {180, 180, 180}}};
constexpr Colour unknown_code{255, 255, 255};

template <class T, class Convert>
Picture pixelwise(const Image& image, Convert convert) {
  Picture picture(image.spec.width, image.spec.height);
  for (int y = 0; y < image.spec.height; ++y) {
    const T* from = image.row<T>(y);
    std::transform(from, from + image.spec.width, picture.row(y), convert);
  }
  return picture;
}

/// All colours a palette gives to n values, so that pixels only look them up.
template <class Value>
std::vector<Colour> table(Palette palette, int n, Value value) {
  std::vector<Colour> colours(n);
  for (int i = 0; i < n; ++i) colours[i] = colour_of(palette, value(i));
  return colours;
}

Picture disparities(const Image& image, Palette palette) {
  const DisparityScale scale = disparity_scale(image.camera);
  const int range = 16 * (scale.to - scale.from);
  const std::vector<Colour> colours = table(palette, range + 1, [&](int i) { return static_cast<double>(i) / range; });
  return pixelwise<int16_t>(image, [&](int16_t d) {
    const uint8_t code = rejected_code(d);
    return code ? rejected_colour(code) : colours[std::clamp(d - 16 * scale.from, 0, range)];
  });
}

Picture votes(const Image& image, Palette palette) {
  const auto place = [](int n) { return 0.06 + 0.94 * std::log1p(n) / std::log1p(votes_scale); };
  const std::vector<Colour> colours = table(palette, votes_scale + 1, place);
  return pixelwise<int16_t>(image, [&](int16_t n) { return n <= 0 ? Colour{12, 12, 16} : colours[std::min<int>(n, votes_scale)]; });
}

Picture heights(const Image& image, Palette palette) {
  const std::vector<Colour> colours = table(palette, height_scale_to - height_scale_from + 1,
                                            [](int i) { return static_cast<double>(i) / (height_scale_to - height_scale_from); });
  return pixelwise<int16_t>(image, [&](int16_t mm) {
    return mm == height_unknown ? colours::panel : colours[std::clamp<int>(mm, height_scale_from, height_scale_to) - height_scale_from];
  });
}

// Rows below the picture are part of the result: obstacles near the camera stand on floor that it does not see.
Picture curve(const Image& image, const PaintStyle& style) {
  const int rows = line_rows(image, style), width = image.spec.width;
  Picture picture(width, rows + rows / 5, {22, 25, 30});
  picture.fill({0, rows, width, rows / 5}, {14, 15, 18});
  for (int x = 0; x < width; x += 128) picture.fill({x, 0, 1, picture.height()}, {44, 48, 56});
  for (int y = 0; y < picture.height(); y += 100) picture.fill({0, y, width, 1}, {44, 48, 56});
  picture.fill({0, rows, width, 1}, colours::dim);
  picture.text(6, rows + 4, "below the picture", colours::dim);
  for (int x = 128; x + 64 < width; x += 128)
    picture.text(x + 4, 4, std::to_string(x / 16 + image.camera.min_disparity) + " px", colours::dim);
  const int16_t* line = image.row<int16_t>(0);
  for (int x = 0; x < width; ++x) {
    if (line[x] == line_none) continue;
    const int from = x > 0 && line[x - 1] != line_none ? line[x - 1] : line[x];
    picture.fill({x, std::min<int>(from, line[x]) - 1, 1, std::abs(line[x] - from) + 3}, colours::warning);
  }
  return picture;
}

Colour map_colour(const GridGeometry& grid, int16_t count, bool seen) {
  if (is_obstacle(grid, count)) {
    const double strength = std::min(1.0, std::log(static_cast<double>(count) / std::max(grid.min_count, 1u) + 1.0) / std::log(50.0));
    const auto channel = [&](int from, int rise) { return static_cast<uint8_t>(from + rise * strength); };
    return {channel(214, 41), channel(60, 110), channel(48, 20)};
  }
  if (count > 0) return {112, 84, 52};
  return seen ? Colour{38, 52, 62} : Colour{22, 24, 29};
}

void draw_ranges(Picture& picture, const GridGeometry& grid, int rows, int cell) {
  const double px = cell / static_cast<double>(grid.cell);
  const bool turned = grid.frame == grid_of_odometry;
  const Place middle = turned ? rover_of(grid) : Place{0, 0};
  const double x0 = static_cast<double>(grid.origin_column) * cell + middle.x * px,
               y0 = static_cast<double>(grid.origin_row) * cell - middle.z * px;
  const double reach = rows * static_cast<double>(grid.cell), step = reach > 400 ? reach / 10 : reach > 60 ? 20 : reach > 12 ? 5 : 1;
  for (double r = step; r < reach * 1.3; r += step) {
    for (double angle = 0; angle < M_PI; angle += 0.6 / (r * px)) {
      const int x = pixel_at(x0 + r * px * std::cos(angle)), y = pixel_at(y0 - r * px * std::sin(angle));
      picture.blend({x, y, 1, 1}, colours::dim, 130);
    }
    // The number stands where the ring leaves the view, so that it hides no obstacle.
    const double side = std::atan(static_cast<double>(grid.view_right));
    const std::string label = std::to_string(static_cast<int>(r)) + " m";
    const int x = std::min(pixel_at(x0 + r * px * std::sin(side)) + 6, picture.width() - Picture::text_width(label) - 2);
    picture.text(x, pixel_at(y0 - r * px * std::cos(side)) - 4, label, colours::text);
  }
  if (turned) {
    // The way the rover heads.
    const double yaw = -static_cast<double>(grid.pose_yaw);
    picture.line(x0, y0, x0 - std::sin(yaw) * px, y0 - std::cos(yaw) * px, colours::accent);
  }
  for (const double slope : {static_cast<double>(grid.view_left), static_cast<double>(grid.view_right)})
    if (!turned) picture.line(x0, y0, x0 + slope * reach * px, y0 - reach * px, colours::accent);
  for (int i = 0; i < 12; ++i) picture.fill({pixel_at(x0) - i / 2, pixel_at(y0) - 12 + i, i / 2 * 2 + 1, 1}, colours::accent);
}

/// A grid as a plan of squares; `colour` is asked by column, row and value.
template <class T, class ColourOf>
Painted plan(const Image& image, const PaintStyle& style, ColourOf colour) {
  const GridGeometry& grid = image.grid;
  const int columns = image.spec.width, rows = image.spec.height;
  const int cell = std::max(1, std::min(style.map_room_width / columns, style.map_room_height / rows));
  Painted painted{Picture(columns * cell, rows * cell), cell};
  for (int y = 0; y < rows; ++y) {
    const T* values = image.row<T>(y);
    for (int x = 0; x < columns; ++x) {
      const int gap = cell > 5 ? 1 : 0;
      painted.picture.fill({x * cell, y * cell, cell, cell}, {16, 18, 22});
      painted.picture.fill({x * cell, y * cell, cell - gap, cell - gap}, colour(x, y, values[x]));
    }
  }
  if (usable(grid)) draw_ranges(painted.picture, grid, rows, cell);
  return painted;
}

Painted counts(const Image& image, const PaintStyle& style) {
  const GridGeometry& grid = image.grid;
  return plan<int16_t>(image, style, [&](int x, int y, int16_t count) { return map_colour(grid, count, in_view(grid, x, y)); });
}

/// For each column how near the nearest obstacle is, nearest below; as bright as it is high, where that is told.
Picture contour(const Image& image) {
  Picture picture(image.spec.width, contour_rows, {22, 25, 30});
  for (int x = 0; x < image.spec.width; ++x) {
    const int row = std::min<int>(image.row<uint8_t>(0)[x], contour_rows - 1);
    if (row == 0) continue;
    const int high = image.spec.height > 1 ? std::min<int>(image.row<uint8_t>(1)[x], contour_heights) : contour_heights;
    const auto channel = [&](int most) { return static_cast<uint8_t>(most * (4 + high) / (4 + contour_heights)); };
    picture.fill({x, 0, 1, row}, {38, 52, 62});
    picture.fill({x, row, 1, contour_rows - row}, {channel(240), channel(110), channel(60)});
  }
  return picture;
}

Picture features(const Image& image, Palette palette) {
  const std::vector<Colour> colours = table(palette, 256, [](int i) { return 0.06 + 0.94 * std::log1p(i) / std::log(256.0); });
  return pixelwise<uint8_t>(image, [&](uint8_t v) { return v ? colours[v] : Colour{12, 12, 16}; });
}

Painted greys(std::string_view topic, const Image& image, const PaintStyle& style) {
  if (is_reason(topic)) return plan<uint8_t>(image, style, [](int, int, uint8_t why) { return reason_colour(why); });
  if (is_true_cells(topic)) return plan<uint8_t>(image, style, [](int, int, uint8_t cell) { return true_cell_colour(cell); });
  if (is_surface(topic)) return {pixelwise<uint8_t>(image, surface_colour)};
  if (is_contour(topic, image)) return {contour(image)};
  if (is_features(topic)) return {features(image, style.palette)};
  if (topic.ends_with("object"))  // numbers of the simulator's objects, 255 the sky: not brightness
    return {pixelwise<uint8_t>(image, [](uint8_t n) {
      return n == 255 ? Colour{14, 15, 18} : n ? labels[n % labels.size()] : colours::panel;
    })};
  if (topic.ends_with("segments"))  // numbers likewise, 0 none
    return {pixelwise<uint8_t>(image, [](uint8_t n) { return n ? labels[n % labels.size()] : colours::panel; })};
  return {pixelwise<uint8_t>(image, [](uint8_t v) { return Colour{v, v, v}; })};
}

}  // namespace

std::string_view name(Palette palette) { return palette == Palette::turbo ? "turbo" : palette == Palette::viridis ? "viridis" : "gray"; }

Colour colour_of(Palette palette, double value) {
  const Stops& stops = palette == Palette::turbo ? turbo : palette == Palette::viridis ? viridis : gray;
  const double place = std::clamp(value, 0.0, 1.0) * static_cast<double>(stops.size() - 1);
  const size_t i = std::min(static_cast<size_t>(place), stops.size() - 2);
  const double part = place - static_cast<double>(i);
  const auto mix = [&](uint8_t a, uint8_t b) { return static_cast<uint8_t>(std::lround(a + (b - a) * part)); };
  return {mix(stops[i].r, stops[i + 1].r), mix(stops[i].g, stops[i + 1].g), mix(stops[i].b, stops[i + 1].b)};
}

Colour rejected_colour(uint8_t code) {
  constexpr std::array<Colour, 8> muted{
      {{0, 0, 0}, {58, 50, 78}, {86, 70, 40}, {38, 76, 74}, {96, 46, 58}, {30, 32, 38}, {64, 66, 70}, {22, 40, 86}}};
  return muted[code < muted.size() ? code : 6];
}

Colour reason_colour(uint8_t cell_reason) {
  // What is known is bright, in the order of CellReason; what is unknown is grey or brown.
  constexpr std::array<Colour, cell_reasons> known{{{22, 24, 29},
                                                    {62, 142, 84},
                                                    {230, 72, 56},
                                                    {216, 64, 204},
                                                    {76, 136, 236},
                                                    {134, 98, 24},
                                                    {52, 56, 64},
                                                    {46, 34, 18},
                                                    {222, 214, 196},
                                                    {118, 120, 124},
                                                    {112, 66, 44},
                                                    {84, 86, 62},
                                                    {168, 146, 118},
                                                    {82, 60, 76},
                                                    {38, 84, 56},
                                                    {156, 52, 40},
                                                    {142, 44, 134}}};
  return cell_reason < known.size() ? known[cell_reason] : unknown_code;
}

Colour surface_colour(uint8_t surface) {
  switch (static_cast<Surface>(surface)) {
    case Surface::none: return colours::panel;
    case Surface::floor: return reason_colour(static_cast<uint8_t>(CellReason::floor));
    case Surface::obstacle: return reason_colour(static_cast<uint8_t>(CellReason::obstacle));
    case Surface::overhang: return reason_colour(static_cast<uint8_t>(CellReason::overhang));
    case Surface::below: return reason_colour(static_cast<uint8_t>(CellReason::drop_off));
    case Surface::filled: return {244, 158, 66};
  }
  return unknown_code;
}

Colour true_cell_colour(uint8_t cell) {
  // As the reason that a cell would have if all of it were seen.
  const auto as = [](CellReason reason) { return reason_colour(static_cast<uint8_t>(reason)); };
  switch (static_cast<TruthCell>(cell)) {
    case TruthCell::outside: return as(CellReason::out_of_view);
    case TruthCell::free: return as(CellReason::floor);
    case TruthCell::obstacle: return as(CellReason::obstacle);
    case TruthCell::drop_off: return as(CellReason::drop_off);
    case TruthCell::overhang: return as(CellReason::overhang);
    case TruthCell::hidden: return as(CellReason::occluded);
    case TruthCell::below: return as(CellReason::remembered_drop_off);
  }
  return unknown_code;
}

Colour occupancy_colour(int8_t percent) {
  if (percent < 0) return {70, 74, 82};
  const auto mix = [](Colour a, Colour b, double part) {
    const auto channel = [&](uint8_t from, uint8_t to) { return static_cast<uint8_t>(std::lround(from + (to - from) * part)); };
    return Colour{channel(a.r, b.r), channel(a.g, b.g), channel(a.b, b.b)};
  };
  if (percent < occupied_from) return mix({46, 132, 74}, {206, 176, 56}, percent / (occupied_from - 1.0));
  return mix({226, 92, 44}, {255, 36, 44}, std::min(1.0, (percent - occupied_from) / (100.0 - occupied_from)));
}

Painted paint(std::string_view topic, const Image& image, const PaintStyle& style) {
  switch (image.spec.pixel) {
    case Pixel::gray8: return greys(topic, image, style);
    case Pixel::mask8: return {pixelwise<uint8_t>(image, [](uint8_t v) { return v ? Colour{236, 92, 60} : Colour{28, 34, 40}; })};
    case Pixel::rgb8: return {pixelwise<Colour>(image, [](Colour v) { return v; })};
    case Pixel::disparity16: return {disparities(image, style.palette)};
    case Pixel::count16: return is_grid(topic) ? counts(image, style) : Painted{votes(image, style.palette)};
    case Pixel::height16: return {heights(image, style.palette)};
    case Pixel::int8: return plan<int8_t>(image, style, [](int, int, int8_t percent) { return occupancy_colour(percent); });
    case Pixel::line16: return {curve(image, style)};
    default: return {Picture(image.spec.width, image.spec.height, colours::panel)};
  }
}

}  // namespace vdisp
