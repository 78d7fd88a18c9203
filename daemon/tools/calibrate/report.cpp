// report.cpp: draws the report: both images with their corners and residuals, error over the image, bars for the views.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/tools/calibrate/report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <opencv2/imgproc.hpp>

#include "ipc/png.h"

namespace vdisp::calibrate {
namespace {

constexpr int panel = 600, margin = 20, bars = 220, heat = 8;  // px; heat: cells across
constexpr double stretched = 50, worst = 1;                    // px drawn for a px of error; px of error that is drawn as the worst
const cv::Scalar paper(250, 250, 250), ink(40, 40, 40), pale(200, 200, 200), red(210, 40, 40), blue(50, 90, 200),
    green(30, 150, 60);  // R G B

void say(cv::Mat& sheet, const std::string& text, const cv::Point& at, double size = 0.45, const cv::Scalar& colour = ink) {
  cv::putText(sheet, text, at, cv::FONT_HERSHEY_SIMPLEX, size, colour, 1, cv::LINE_AA);
}

/// From green at no error to red at the worst.
cv::Scalar shade(double error) {
  const double t = std::min(error / worst, 1.0);
  return {255 * std::min(1.0, 2 * t), 255 * std::min(1.0, 2 - 2 * t) * 0.75, 40};
}

/// Corners of all used views with their residuals, fifty times as long.
void draw_corners(cv::Mat sheet, const Solution& solution, const std::vector<View>& views, int side) {
  const double scale = static_cast<double>(sheet.cols) / solution.size.width;
  for (const View& view : views) {
    if (!view.used()) continue;
    for (size_t n = 0; n < view.board[side].corners.size(); ++n) {
      const cv::Point2d at = scale * cv::Point2d(view.board[side].corners[n]), off = cv::Point2d(view.residuals[side][n]);
      cv::line(sheet, at, at + scale * stretched * off, shade(cv::norm(off)), 1, cv::LINE_AA);
      cv::circle(sheet, at, 2, ink, cv::FILLED, cv::LINE_AA);
    }
  }
}

/// Mean error in cells of the image; cells without corners stay white.
void draw_heat(cv::Mat sheet, const Solution& solution, const std::vector<View>& views, int side) {
  const int down = std::max(1, heat * solution.size.height / solution.size.width);
  cv::Mat sum = cv::Mat::zeros(down, heat, CV_64F), count = cv::Mat::zeros(down, heat, CV_64F);
  for (const View& view : views) {
    if (!view.used()) continue;
    for (size_t n = 0; n < view.board[side].corners.size(); ++n) {
      const cv::Point2f corner = view.board[side].corners[n];
      const int x = std::clamp(static_cast<int>(corner.x * heat / static_cast<float>(solution.size.width)), 0, heat - 1);
      const int y =
          std::clamp(static_cast<int>(corner.y * static_cast<float>(down) / static_cast<float>(solution.size.height)), 0, down - 1);
      sum.at<double>(y, x) += cv::norm(view.residuals[side][n]);
      count.at<double>(y, x) += 1;
    }
  }
  for (int y = 0; y < down; ++y)
    for (int x = 0; x < heat; ++x) {
      const cv::Rect cell(cv::Point(x * sheet.cols / heat, y * sheet.rows / down),
                          cv::Point((x + 1) * sheet.cols / heat, (y + 1) * sheet.rows / down));
      if (count.at<double>(y, x) == 0) continue;
      const double mean = sum.at<double>(y, x) / count.at<double>(y, x);
      cv::rectangle(sheet, cell, 0.35 * shade(mean) + 0.65 * paper, cv::FILLED);
      char text[16];
      std::snprintf(text, sizeof text, "%.2f", mean);
      say(sheet, text, cell.tl() + cv::Point(4, 14), 0.38, cv::Scalar(110, 110, 110));
    }
}

void draw_views(cv::Mat sheet, const std::vector<View>& views) {
  double most = 0.3;
  for (const View& view : views) most = std::max({most, view.rms[0], view.rms[1], view.rows});
  const int floor = sheet.rows - 40, top = 30;
  const double unit = (floor - top) / most,
               step = static_cast<double>(sheet.cols - 50) / static_cast<double>(std::max<size_t>(views.size(), 1));
  for (double line = 0; line <= most; line += most > 1.5 ? 0.5 : 0.1) {
    const int y = floor - static_cast<int>(line * unit);
    cv::line(sheet, {45, y}, {sheet.cols, y}, pale);
    char text[16];
    std::snprintf(text, sizeof text, "%.1f", line);
    say(sheet, text, {8, y + 4}, 0.4);
  }
  for (size_t i = 0; i < views.size(); ++i) {
    const View& view = views[i];
    const double x = 50 + static_cast<double>(i) * step, width = std::max(1.0, step / 4);
    const std::pair<double, cv::Scalar> values[] = {{view.rms[0], blue}, {view.rms[1], green}, {view.rows, ink}};
    for (size_t n = 0; n < 3; ++n) {
      const cv::Scalar colour = view.used() ? values[n].second : cv::Scalar(230, 170, 170);
      cv::rectangle(sheet, cv::Point2d(x + static_cast<double>(n) * width, floor - values[n].first * unit),
                    cv::Point2d(x + static_cast<double>(n + 1) * width - 1, floor), colour, cv::FILLED);
    }
    say(sheet, std::to_string(i + 1), cv::Point(static_cast<int>(x), floor + 16), 0.4, view.used() ? ink : red);
  }
  say(sheet, "px of each pair: left (blue), right (green), rows after rectification (black); red number: rejected", {50, 16});
}

}  // namespace

void write_report(const std::filesystem::path& file, const Solution& solution, const std::vector<View>& views) {
  const int height = panel * solution.size.height / solution.size.width, width = 2 * panel + 3 * margin, head = 70;
  cv::Mat sheet(head + height + margin + bars, width, CV_8UC3, paper);
  char title[200];
  std::snprintf(title, sizeof title, "reprojection %.3f px, rows %.3f px (median) %.3f (95 %%), f %.1f and %.1f px, baseline %.2f mm",
                solution.rms, solution.rows_median, solution.rows_p95, (*solution.calibration.raw)[0].k[0],
                (*solution.calibration.raw)[1].k[0], 1000 * solution.calibration.view.baseline);
  say(sheet, title, {margin, 24}, 0.55);
  say(sheet, solution.faults.empty() ? "usable" : "not usable: " + solution.faults[0], {margin, 44}, 0.5,
      solution.faults.empty() ? green : red);
  for (int side : {0, 1}) {
    cv::Mat view = sheet(cv::Rect(margin + side * (panel + margin), head, panel, height));
    view.setTo(cv::Scalar(255, 255, 255));
    draw_heat(view, solution, views, side);
    draw_corners(view, solution, views, side);
    cv::rectangle(view, cv::Rect(0, 0, panel, height), pale);
    say(sheet, side == 0 ? "left: corners, errors x50, their mean" : "right", {margin + side * (panel + margin), head - 8});
  }
  draw_views(sheet(cv::Rect(margin, head + height + margin, width - 2 * margin, bars)), views);
  write_file(file, encode_png(PngKind::rgb8, sheet.cols, sheet.rows, [&sheet](int y) { return sheet.ptr(y); }));
}

}  // namespace vdisp::calibrate
