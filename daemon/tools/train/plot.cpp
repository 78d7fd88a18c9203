// plot.cpp: one layout, two pens.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/tools/train/plot.h"

#include <cmath>
#include <cstdio>
#include <opencv2/imgproc.hpp>

#include "ipc/png.h"

namespace vdisp::train {
namespace {

constexpr int width = 640, height = 640, left = 80, top = 50, side = 500;  // px
using Colour = std::array<int, 3>;                                         // R G B
constexpr Colour ink{40, 40, 40}, pale{215, 215, 215}, shade{225, 234, 245};
constexpr Colour colours[] = {{200, 30, 30}, {30, 90, 190}, {20, 140, 60}, {190, 110, 0}, {120, 50, 160}, {90, 90, 90}};

using Point = std::array<double, 2>;
using Points = std::vector<Point>;
enum class Anchor { start, middle, end };

/// px of a point of the unit square.
Point at(double x, double y) { return {left + x * side, top + (1 - y) * side}; }

// A pen draws lines, areas and text (upwards where `turned`); there are two, and draw() is made for each.

class SvgPen {
 public:
  void line(const Points& points, const Colour& colour, int thick) {
    put("<polyline fill=\"none\" stroke=\"" + hex(colour) + "\" stroke-width=\"" + std::to_string(thick) + "\" points=\"" + list(points) +
        "\"/>");
  }
  void area(const Points& points, const Colour& colour) { put("<polygon fill=\"" + hex(colour) + "\" points=\"" + list(points) + "\"/>"); }
  void text(const std::string& text, Point p, int size, Anchor anchor, bool turned = false) {
    static constexpr const char* anchors[] = {"start", "middle", "end"};
    const std::string place = number(p[0]) + (turned ? " " : "\" y=\"") + number(p[1]);
    const std::string where = turned ? "transform=\"translate(" + place + ") rotate(-90)\"" : "x=\"" + place + "\"";
    put("<text " + where + " font-size=\"" + std::to_string(size) + "\" text-anchor=\"" + anchors[static_cast<int>(anchor)] + "\">" +
        escaped(text) + "</text>");
  }
  std::string whole() const {
    const std::string size = "width=\"" + std::to_string(width) + "\" height=\"" + std::to_string(height) + "\"";
    return "<svg xmlns=\"http://www.w3.org/2000/svg\" " + size + " font-family=\"sans-serif\" fill=\"" + hex(ink) + "\">\n<rect " + size +
           " fill=\"white\"/>\n" + body_ + "</svg>\n";
  }

 private:
  static std::string number(double value) {
    char digits[32];
    std::snprintf(digits, sizeof digits, "%.2f", value);
    return digits;
  }
  static std::string hex(const Colour& colour) {
    char digits[16];
    std::snprintf(digits, sizeof digits, "#%02x%02x%02x", colour[0], colour[1], colour[2]);
    return digits;
  }
  static std::string list(const Points& points) {
    std::string text;
    for (const Point& p : points) text += (text.empty() ? "" : " ") + number(p[0]) + "," + number(p[1]);
    return text;
  }
  static std::string escaped(const std::string& text) {
    std::string safe;
    for (const char c : text) safe += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : std::string(1, c);
    return safe;
  }
  void put(const std::string& element) { body_ += element + "\n"; }
  std::string body_;
};

class PngPen {
 public:
  PngPen() : sheet_(height, width, CV_8UC3, cv::Scalar(255, 255, 255)) {}
  void line(const Points& points, const Colour& colour, int thick) {
    cv::polylines(sheet_, std::vector{fixed(points)}, false, scalar(colour), thick, cv::LINE_AA, shift);
  }
  void area(const Points& points, const Colour& colour) {
    cv::fillPoly(sheet_, std::vector{fixed(points)}, scalar(colour), cv::LINE_AA, shift);
  }
  void text(const std::string& text, Point p, int size, Anchor anchor, bool turned = false) {
    const double scale = size / 28.0;
    int base = 0;
    const cv::Size box = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, scale, 1, &base);
    cv::Mat strip(box.height + 2 * base, box.width + 4, CV_8UC3, cv::Scalar(255, 255, 255));
    cv::putText(strip, text, {2, box.height + base / 2}, cv::FONT_HERSHEY_SIMPLEX, scale, scalar(ink), 1, cv::LINE_AA);
    const double ahead = anchor == Anchor::start ? 0 : anchor == Anchor::middle ? 0.5 * strip.cols : strip.cols;
    cv::Point corner(static_cast<int>(p[0] - ahead), static_cast<int>(p[1]) - box.height - base / 2);
    if (turned) {
      cv::rotate(strip, strip, cv::ROTATE_90_COUNTERCLOCKWISE);
      corner = {static_cast<int>(p[0]) - box.height, static_cast<int>(p[1] + ahead - strip.rows)};
    }
    const cv::Rect place = cv::Rect(corner, strip.size()) & cv::Rect({}, sheet_.size());
    cv::Mat part = sheet_(place);
    cv::min(part, strip(cv::Rect(place.tl() - corner, place.size())), part);
  }
  std::string whole() const {
    return encode_png(PngKind::rgb8, width, height, [this](int y) { return sheet_.ptr(y); });
  }

 private:
  static constexpr int shift = 4;
  static cv::Scalar scalar(const Colour& c) { return {double(c[0]), double(c[1]), double(c[2])}; }
  static std::vector<cv::Point> fixed(const Points& points) {
    std::vector<cv::Point> all;
    for (const Point& p : points) all.emplace_back(std::lround(p[0] * (1 << shift)), std::lround(p[1] * (1 << shift)));
    return all;
  }
  cv::Mat sheet_;
};

template <class Pen>
void draw_frame(const Plot& plot, Pen& pen) {
  for (int i = 0; i <= 5; ++i) {
    const double part = i / 5.0;
    char tick[8];
    std::snprintf(tick, sizeof tick, "%.1f", part);
    pen.line({at(part, 0), at(part, 1)}, pale, 1);
    pen.line({at(0, part), at(1, part)}, pale, 1);
    pen.text(tick, {at(part, 0)[0], top + side + 20}, 14, Anchor::middle);
    pen.text(tick, {left - 8, at(0, part)[1] + 5}, 14, Anchor::end);
  }
  pen.line({at(0, 0), at(1, 1)}, pale, 1);
  pen.line({at(0, 0), at(1, 0), at(1, 1), at(0, 1), at(0, 0)}, ink, 1);
  pen.text(plot.title, {left + side / 2.0, 30}, 17, Anchor::middle);
  pen.text(plot.x, {left + side / 2.0, top + side + 48}, 15, Anchor::middle);
  pen.text(plot.y, {30, top + side / 2.0}, 15, Anchor::middle, true);
}

template <class Pen>
void draw(const Plot& plot, Pen& pen) {
  if (plot.filled && !plot.curves.empty()) {
    Points under;
    for (const auto& [x, y] : plot.curves[0].points) under.push_back(at(x, y));
    under.push_back(at(1, 0)), under.push_back(at(0, 0));
    pen.area(under, shade);
    pen.text("Area Under Curve", at(0.5, 0.45), 15, Anchor::middle);
  }
  draw_frame(plot, pen);
  for (size_t i = 0; i < plot.curves.size(); ++i) {
    const Colour& colour = colours[i % std::size(colours)];
    Points drawn;
    for (const auto& [x, y] : plot.curves[i].points) drawn.push_back(at(x, y));
    pen.line(drawn, colour, 2);
    const Point key = at(0.5, 0.30 - 0.05 * static_cast<double>(i));
    pen.line({key, {key[0] + 40, key[1]}}, colour, 2);
    pen.text(plot.curves[i].name, {key[0] + 48, key[1] + 5}, 14, Anchor::start);
  }
}

template <class Pen>
std::string drawn(const Plot& plot) {
  Pen pen;
  draw(plot, pen);
  return pen.whole();
}

}  // namespace

std::string svg_of(const Plot& plot) { return drawn<SvgPen>(plot); }
std::string png_of(const Plot& plot) { return drawn<PngPen>(plot); }

}  // namespace vdisp::train
