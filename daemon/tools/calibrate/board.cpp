// board.cpp: finds chessboards and ChArUco boards with OpenCV, and refines their corners.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/tools/calibrate/board.h"

#include <sysexits.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

namespace vdisp::calibrate {
namespace {

constexpr int fewest_charuco = 8;

/// OpenCV numbers DICT_4X4_50 .. DICT_7X7_1000 in order.
int dictionary_number(const std::string& name) {
  constexpr const char* sizes[] = {"4X4", "5X5", "6X6", "7X7"};
  constexpr const char* counts[] = {"50", "100", "250", "1000"};
  for (int size = 0; size < 4; ++size)
    for (int count = 0; count < 4; ++count)
      if (name == std::string("DICT_") + sizes[size] + "_" + counts[count]) return 4 * size + count;
  throw ToolError(EX_USAGE, "--dictionary " + name + " is unknown; needed is DICT_4X4_50, DICT_5X5_100 and so on up to DICT_7X7_1000");
}

constexpr int near_by = 5, far_off = 11;  // px to each side that the refinement looks at
constexpr double astray = 0.5;            // px

/// No farther than where the next corner comes in sight.
int reach_of(const std::vector<cv::Point2f>& corners, int most) {
  double nearest = 1e9;
  for (size_t i = 0; i < corners.size(); ++i)
    for (size_t j = i + 1; j < corners.size(); ++j) nearest = std::min(nearest, cv::norm(corners[i] - corners[j]));
  return std::clamp(static_cast<int>(0.4 * nearest), 2, most);
}

/// The larger window is less noisy, and led astray by the board's rim or a fold: then the smaller one is believed.
void refine(const cv::Mat& gray, std::vector<cv::Point2f>& corners) {
  const auto within = [&gray](std::vector<cv::Point2f>& points, int reach) {
    cv::cornerSubPix(gray, points, {reach, reach}, {-1, -1}, {cv::TermCriteria::EPS + cv::TermCriteria::COUNT, 60, 1e-4});
  };
  const int small = reach_of(corners, near_by), large = reach_of(corners, far_off);
  within(corners, small);
  std::vector<cv::Point2f> better = corners;
  within(better, large);
  for (size_t i = 0; i < corners.size(); ++i)
    if (cv::norm(better[i] - corners[i]) < astray) corners[i] = better[i];
}

}  // namespace

Board::Board(const BoardOptions& options)
    : charuco_(options.kind == "charuco"),
      square_(options.square_m),
      marker_(options.marker_m > 0 ? options.marker_m : 0.75 * options.square_m) {
  int used = 0;
  const int least = charuco_ ? 3 : 2;
  if (std::sscanf(options.size.c_str(), "%3dx%3d%n", &columns_, &rows_, &used) != 2 || static_cast<size_t>(used) != options.size.size() ||
      columns_ < least || rows_ < least || columns_ > 100 || rows_ > 100 || columns_ * rows_ < 6)
    throw ToolError(EX_USAGE, "--board " + options.size + ": needed is the number of " +
                                  (charuco_ ? "squares across and down, as 8x6" : "inner corners across and down, as 9x6"));
  if (marker_ >= square_) throw ToolError(EX_USAGE, "--marker is not smaller than --square; needed are markers within the squares");
  if (charuco_) dictionary_ = dictionary_number(options.dictionary);
}

std::vector<cv::Point3f> Board::places(const std::vector<int>& ids) const {
  std::vector<cv::Point3f> places;
  for (int id : ids) places.emplace_back(static_cast<float>(id % across() * square_), static_cast<float>(id / across() * square_), 0.f);
  return places;
}

std::vector<std::pair<int, int>> Board::neighbours() const {
  std::vector<std::pair<int, int>> pairs;
  for (int id = 0; id < corners(); ++id) {
    if (id % across() + 1 < across()) pairs.emplace_back(id, id + 1);
    if (id + across() < corners()) pairs.emplace_back(id, id + across());
  }
  return pairs;
}

BoardView Board::find(const cv::Mat& gray) const { return charuco_ ? find_charuco(gray) : find_chessboard(gray); }

BoardView Board::find_chessboard(const cv::Mat& gray) const {
  BoardView view;
  const cv::Size size(columns_, rows_);
  const int flags = cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE;
  // The second finder sees boards that are blurred or large; both are refined alike.
  if (!cv::findChessboardCorners(gray, size, view.corners, flags | cv::CALIB_CB_FAST_CHECK) &&
      !cv::findChessboardCornersSB(gray, size, view.corners, cv::CALIB_CB_NORMALIZE_IMAGE))
    return {};
  refine(gray, view.corners);
  for (int id = 0; id < corners(); ++id) view.ids.push_back(id);
  return view;
}

BoardView Board::find_charuco(const cv::Mat& gray) const {
  const auto dictionary = cv::aruco::getPredefinedDictionary(dictionary_);
  const auto board = cv::aruco::CharucoBoard::create(columns_, rows_, static_cast<float>(square_), static_cast<float>(marker_), dictionary);
  std::vector<std::vector<cv::Point2f>> markers;
  std::vector<int> marker_ids;
  cv::aruco::detectMarkers(gray, dictionary, markers, marker_ids);
  BoardView view;
  if (marker_ids.empty()) return view;
  cv::aruco::interpolateCornersCharuco(markers, marker_ids, gray, board, view.corners, view.ids);
  if (static_cast<int>(view.ids.size()) < fewest_charuco) return {};
  refine(gray, view.corners);
  return view;
}

void Board::agree(const BoardView& left, BoardView& right) const {
  if (charuco_ || left.empty() || right.empty()) return;
  const cv::Point2f a = left.corners.back() - left.corners.front(), b = right.corners.back() - right.corners.front();
  if (a.dot(b) < 0) std::reverse(right.corners.begin(), right.corners.end());
}

void keep_common(BoardView& left, BoardView& right) {
  std::map<int, cv::Point2f> there;
  for (size_t i = 0; i < right.ids.size(); ++i) there[right.ids[i]] = right.corners[i];
  BoardView a, b;
  for (size_t i = 0; i < left.ids.size(); ++i) {
    const auto found = there.find(left.ids[i]);
    if (found == there.end()) continue;
    a.ids.push_back(left.ids[i]);
    a.corners.push_back(left.corners[i]);
    b.corners.push_back(found->second);
  }
  b.ids = a.ids;
  left = std::move(a);
  right = std::move(b);
}

}  // namespace vdisp::calibrate
