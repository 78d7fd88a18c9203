// row_matches.cpp: correlation of windows over a strip at a reduced size, then optical flow at full size.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/tools/calibrate/row_matches.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

namespace vdisp::calibrate {
namespace {

constexpr int working_width = 480, window = 15, most_corners = 400;
constexpr int least_matches = 40;
constexpr double good = 0.85, rival = 0.93;         // correlation; of the second best to the best
constexpr int own_peak = 3;                         // px: nearer than that it is the same peak
constexpr float leads_back = 0.2f, refined_by = 4;  // px

/// Where the window around `at` is in the right view, both small; (-1, -1): nowhere, or in two places.
cv::Point correlate(const cv::Mat& left, const cv::Mat& right, const cv::Point& at, int across, int down) {
  constexpr int half = window / 2;
  const cv::Rect all(0, 0, left.cols, left.rows), place(at.x - half, at.y - half, window, window);
  const cv::Rect strip = cv::Rect(place.x - across, place.y - down, window + 2 * across, window + 2 * down) & all;
  if ((place & all) != place) return {-1, -1};
  cv::Mat score;
  cv::matchTemplate(right(strip), left(place), score, cv::TM_CCOEFF_NORMED);
  double best = 0, second = 0;
  cv::Point where;
  cv::minMaxLoc(score, nullptr, &best, nullptr, &where);
  if (best < good) return {-1, -1};
  const cv::Rect peak = cv::Rect(where.x - own_peak, where.y - own_peak, 2 * own_peak + 1, 2 * own_peak + 1) & cv::Rect({}, score.size());
  score(peak).setTo(-1);
  cv::minMaxLoc(score, nullptr, &second);
  if (second > rival * best) return {-1, -1};
  return strip.tl() + where + cv::Point(half, half);
}

/// Guesses to a fraction of a pixel, at full size.
std::vector<RowMatch> refine(const cv::Mat& left, const cv::Mat& right, const std::vector<cv::Point2f>& from,
                             const std::vector<cv::Point2f>& guesses) {
  std::vector<RowMatch> matches;
  if (from.empty()) return matches;
  std::vector<cv::Point2f> to = guesses, back = from;
  std::vector<uint8_t> found, found_back;
  std::vector<float> error;
  const cv::TermCriteria enough(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 40, 0.005);
  const cv::Size size(21, 21);
  cv::calcOpticalFlowPyrLK(left, right, from, to, found, error, size, 1, enough, cv::OPTFLOW_USE_INITIAL_FLOW, 1e-3);
  cv::calcOpticalFlowPyrLK(right, left, to, back, found_back, error, size, 1, enough, cv::OPTFLOW_USE_INITIAL_FLOW, 1e-3);
  const double scale = static_cast<double>(left.cols) / working_width;
  for (size_t i = 0; i < from.size(); ++i) {
    const bool there = found[i] && found_back[i] && cv::norm(back[i] - from[i]) < leads_back;
    if (there && cv::norm(to[i] - guesses[i]) < refined_by * std::max(1.0, scale)) matches.push_back({from[i], to[i]});
  }
  return matches;
}

}  // namespace

std::vector<RowMatch> match_rows(const cv::Mat& left, const cv::Mat& right) {
  const double scale = std::max(1.0, static_cast<double>(left.cols) / working_width);
  cv::Mat small[2];
  const cv::Size size(cvRound(left.cols / scale), cvRound(left.rows / scale));
  cv::resize(left, small[0], size, 0, 0, cv::INTER_AREA);
  cv::resize(right, small[1], size, 0, 0, cv::INTER_AREA);
  std::vector<cv::Point2f> corners;
  cv::goodFeaturesToTrack(small[0], corners, most_corners, 0.01, 8);
  std::vector<RowMatch> matches;
  // Rows that are far off are looked for only where hardly one is found nearby.
  for (int down : {size.height / 40 + 2, size.height / 8}) {
    std::vector<cv::Point2f> from, guesses;
    for (const cv::Point2f& corner : corners) {
      const cv::Point found = correlate(small[0], small[1], corner, size.width * 3 / 10, down);
      if (found.x < 0) continue;
      const auto full = [&](const cv::Point2f& p) { return cv::Point2f((p + cv::Point2f(0.5f, 0.5f)) * scale) - cv::Point2f(0.5f, 0.5f); };
      from.push_back(full(cv::Point(corner)));
      guesses.push_back(full(found));
    }
    matches = refine(left, right, from, guesses);
    if (matches.size() >= least_matches) break;
  }
  return matches;
}

}  // namespace vdisp::calibrate
