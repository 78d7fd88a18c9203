// capture_window.cpp: the layout: all that the terminal says in words, for the eye.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/tools/calibrate/capture_window.h"

#include <sysexits.h>

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "daemon/tools/calibrate/words.h"

namespace vdisp::calibrate {
namespace {

constexpr Colour background{18, 20, 24}, panel{30, 33, 39}, ink{222, 226, 232}, dim{140, 148, 160}, good{96, 200, 120},
    wanting{208, 150, 60}, found{80, 220, 255}, before{110, 120, 190};
constexpr int bar = 30, margin = 10, below = 150;

Picture picture_of_view(const cv::Mat& view) {
  Picture picture(view.cols, view.rows);
  for (int y = 0; y < view.rows; ++y)
    for (int x = 0; x < view.cols; ++x) {
      const uint8_t grey = view.at<uint8_t>(y, x);
      picture.row(y)[x] = {grey, grey, grey};
    }
  return picture;
}

/// One view in its room, with the corners found in it; over the left one also where boards were.
void draw_view(Picture& page, Box room, const cv::Mat& view, const BoardView* seen, const std::vector<std::pair<int, int>>& neighbours,
               const ViewCollector* outlines) {
  const Box box = fitted(view.cols, view.rows, room);
  page.draw(picture_of_view(view), box);
  const double scale = static_cast<double>(box.width) / view.cols;
  const auto x = [&](const cv::Point2f& p) { return box.x + (static_cast<double>(p.x) + 0.5) * scale; };
  const auto y = [&](const cv::Point2f& p) { return box.y + (static_cast<double>(p.y) + 0.5) * scale; };
  if (outlines)
    for (const TakenView& taken : outlines->views())
      for (size_t i = 0; i < 4; ++i) {
        const cv::Point2f &a = taken.outline[i], &b = taken.outline[(i + 1) % 4];
        page.line(x(a), y(a), x(b), y(b), before);
      }
  if (!seen || seen->empty()) return;
  std::map<int, cv::Point2f> corners;
  for (size_t i = 0; i < seen->ids.size(); ++i) corners[seen->ids[i]] = seen->corners[i];
  for (const auto& [one, other] : neighbours)
    if (const auto a = corners.find(one), b = corners.find(other); a != corners.end() && b != corners.end())
      page.line(x(a->second), y(a->second), x(b->second), y(b->second), found);
  for (const cv::Point2f& corner : seen->corners)
    page.frame({static_cast<int>(x(corner)) - 2, static_cast<int>(y(corner)) - 2, 5, 5}, wanting);
}

/// The nine parts of the image: how many corners each has seen, green where that is enough.
void draw_cells(Picture& page, int x, int y, const ViewCollector& collector) {
  page.text(x, y, "image", dim);
  for (int i = 0; i < 9; ++i) {
    const Box cell{x + i % 3 * 52, y + 20 + i / 3 * 34, 50, 32};
    const bool enough = collector.covered(static_cast<size_t>(i));
    page.fill(cell, panel);
    page.frame(cell, enough ? good : wanting);
    page.text(cell.x + 6, cell.y + 8, std::to_string(collector.cells()[static_cast<size_t>(i)]), enough ? good : wanting);
  }
}

void draw_poses(Picture& page, int x, int y, const ViewCollector& collector) {
  page.text(x, y, "poses", dim);
  for (size_t i = 0; i < tilts; ++i) {
    const int row = y + 22 + static_cast<int>(i) * 24;
    const bool there = collector.tilted(i);
    page.fill({x, row + 2, 12, 12}, there ? good : panel);
    page.frame({x, row + 2, 12, 12}, there ? good : wanting);
    page.text(x + 20, row, tilt_names[i], there ? ink : wanting);
  }
}

}  // namespace

Picture draw_capture(const CaptureScreen& screen, int width, int height) {
  Picture page(width, height, background);
  page.fill({0, 0, width, bar}, panel);
  page.text(margin, 7, screen.message, ink);
  const std::string keys = "space take   u undo   q quit";
  page.text(width - Picture::text_width(keys) - margin, height - below, keys, dim);
  const int half = (width - 3 * margin) / 2, end = height - below;
  const auto neighbours = screen.board ? screen.board->neighbours() : std::vector<std::pair<int, int>>();
  if (screen.views)
    for (int i : {0, 1})
      draw_view(page, {margin + i * (half + margin), bar + margin, half, std::max(end - bar - 2 * margin, 16)}, screen.views[i],
                screen.seen[i], neighbours, i == 0 ? screen.collector : nullptr);
  if (!screen.collector) return page;
  draw_cells(page, margin, end, *screen.collector);
  draw_poses(page, margin + 190, end, *screen.collector);
  const size_t taken = screen.collector->taken();
  page.text(margin + 430, end, "views", dim);
  page.text(margin + 430, end + 22, std::to_string(taken) + " of " + std::to_string(screen.wanted), taken >= screen.wanted ? good : ink, 2);
  return page;
}

CaptureWindow::CaptureWindow() try : window_("vdisp-calibrate capture", 1000, 560) {
} catch (const NoWindow& error) {
  throw ToolError(EX_UNAVAILABLE, std::string(error.what()) + "; without --window it works in a terminal");
}

void CaptureWindow::show(const CaptureScreen& screen) { window_.show(draw_capture(screen, window_.width(), window_.height())); }

CaptureWindow::Asked CaptureWindow::keys(int limit_ms) {
  Asked asked;
  for (auto input = window_.wait(limit_ms); input; input = window_.wait(0)) {
    if (*input == Input::space) asked.take = true;
    if (*input == Input::undo) asked.undo = true;
    if (*input == Input::quit) asked.quit = true;
  }
  return asked;
}

}  // namespace vdisp::calibrate
