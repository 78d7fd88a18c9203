// stereo_solution.cpp: calibrates with OpenCV, rejects views that do not fit, and judges the result.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/tools/calibrate/stereo_solution.h"

#include <sysexits.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <opencv2/calib3d.hpp>

#include "daemon/geometry/calibration_write.h"
#include "daemon/tools/calibrate/judgement.h"

namespace vdisp::calibrate {
namespace {

constexpr double times_median = 2.5, surely_bad = 0.4;  // px: with a median of 0.1 px a view of 0.3 is still good

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

struct Cameras {
  cv::Mat k[2], d[2];
  cv::Matx33d rotation;
  cv::Vec3d translation;
  cv::Mat errors;  // RMS of each view, left and right
  double rms = 0, f_deviation = 0;
};

/// What OpenCV takes: one vector for each view that is used.
struct Lists {
  std::vector<std::vector<cv::Point3f>> places;
  std::vector<std::vector<cv::Point2f>> seen[2];
  std::vector<View*> views;
};

Lists lists_of(const Board& board, std::vector<View>& views) {
  Lists lists;
  for (View& view : views) {
    if (!view.used()) continue;
    lists.places.push_back(board.places(view.board[0].ids));
    for (int i : {0, 1}) lists.seen[i].push_back(view.board[i].corners);
    lists.views.push_back(&view);
  }
  return lists;
}

Cameras calibrate(const Lists& lists, const cv::Size& size) {
  Cameras cameras;
  const cv::TermCriteria enough(cv::TermCriteria::EPS + cv::TermCriteria::COUNT, 100, 1e-7);
  std::vector<cv::Mat> turns, shifts;
  cv::Mat deviations, unused, essential, fundamental;
  for (int i : {0, 1}) {
    cv::calibrateCamera(lists.places, lists.seen[i], size, cameras.k[i], cameras.d[i], turns, shifts, deviations, unused, unused, 0,
                        enough);
    cameras.f_deviation = std::max(cameras.f_deviation, deviations.at<double>(0) / cameras.k[i].at<double>(0, 0));
  }
  cameras.rms = cv::stereoCalibrate(lists.places, lists.seen[0], lists.seen[1], cameras.k[0], cameras.d[0], cameras.k[1], cameras.d[1],
                                    size, cameras.rotation, cameras.translation, essential, fundamental, cameras.errors,
                                    cv::CALIB_USE_INTRINSIC_GUESS, enough);
  return cameras;
}

/// Where a board is: rotation vector and shift, board to camera.
struct Place {
  cv::Vec3d turn, shift;
};

/// The same board seen from the right camera; `by` is 6x6: how that changes with the place.
Place from_right(const Cameras& cameras, const Place& place, cv::Mat& by) {
  cv::Vec3d turn;
  cv::Rodrigues(cameras.rotation, turn);
  Place result;
  cv::Mat r_r1, r_t1, r_r2, r_t2, t_r1, t_t1, t_r2, t_t2;
  cv::composeRT(place.turn, place.shift, turn, cameras.translation, result.turn, result.shift, r_r1, r_t1, r_r2, r_t2, t_r1, t_t1, t_r2,
                t_t2);
  cv::Mat above, below;
  cv::hconcat(r_r1, r_t1, above);
  cv::hconcat(t_r1, t_t1, below);
  cv::vconcat(above, below, by);
  return result;
}

/// Places that both views agree with best, by Gauss and Newton from where the left one alone sees the board; residuals come with it.
Place place_board(const Cameras& cameras, const std::vector<cv::Point3f>& places, View& view) {
  constexpr int rounds = 6;
  Place place;
  cv::solvePnP(places, view.board[0].corners, cameras.k[0], cameras.d[0], place.turn, place.shift);
  for (int round = 0; round < rounds; ++round) {
    cv::Mat normal = cv::Mat::zeros(6, 6, CV_64F), right = cv::Mat::zeros(6, 1, CV_64F), by = cv::Mat::eye(6, 6, CV_64F);
    for (int i : {0, 1}) {
      const Place seen = i == 0 ? place : from_right(cameras, place, by);
      std::vector<cv::Point2f> expected;
      cv::Mat slopes;
      cv::projectPoints(places, seen.turn, seen.shift, cameras.k[i], cameras.d[i], expected, slopes);
      const cv::Mat steps = slopes.colRange(0, 6) * by;
      cv::Mat off(2 * static_cast<int>(expected.size()), 1, CV_64F);
      view.residuals[i].clear();
      for (size_t n = 0; n < expected.size(); ++n) {
        view.residuals[i].push_back(view.board[i].corners[n] - expected[n]);
        off.at<double>(2 * static_cast<int>(n)) = view.residuals[i].back().x;
        off.at<double>(2 * static_cast<int>(n) + 1) = view.residuals[i].back().y;
      }
      normal += steps.t() * steps;
      right += steps.t() * off;
    }
    if (round + 1 == rounds) break;
    cv::Mat change;
    cv::solve(normal, right, change, cv::DECOMP_SVD);
    place.turn += cv::Vec3d(change.ptr<double>(0));
    place.shift += cv::Vec3d(change.ptr<double>(3));
  }
  return place;
}

/// Errors, tilt and residuals of the `n`th view that is used.
void measure_view(const Cameras& cameras, size_t n, const std::vector<cv::Point3f>& places, View& view) {
  cv::Matx33d pose;
  cv::Rodrigues(place_board(cameras, places, view).turn, pose);
  view.tilt_across = std::atan2(pose(0, 2), std::abs(pose(2, 2)));
  view.tilt_down = std::atan2(pose(1, 2), std::abs(pose(2, 2)));
  for (int i : {0, 1}) view.rms[i] = cameras.errors.at<double>(static_cast<int>(n), i);
}

/// Marks the views that fit far worse than the median one. False: all fit.
bool reject_worst(const Lists& lists, size_t most) {
  std::vector<double> errors;
  for (const View* view : lists.views) errors.push_back(std::max(view->rms[0], view->rms[1]));
  const double limit = std::max(times_median * median(errors), surely_bad);
  std::vector<size_t> order(errors.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::sort(order.begin(), order.end(), [&errors](size_t a, size_t b) { return errors[a] > errors[b]; });
  size_t count = 0;
  for (size_t i : order) {
    if (errors[i] <= limit || count == most) break;
    char why[120];
    std::snprintf(why, sizeof why, "corners are %.2f px from where they should be, those of the other views %.2f: blurred, moved, or bent",
                  errors[i], median(errors));
    lists.views[i]->rejected = why;
    ++count;
  }
  return count > 0;
}

Calibration calibration_of(const Cameras& cameras, const cv::Size& size) {
  std::array<RawCamera, 2> raw;
  for (int i : {0, 1}) {
    std::copy_n(cameras.k[i].ptr<double>(), 9, raw[i].k.begin());
    std::copy_n(cameras.d[i].ptr<double>(), std::min<size_t>(cameras.d[i].total(), 8), raw[i].distortion.begin());
  }
  Stand stand;
  std::copy_n(cameras.rotation.val, 9, stand.rotation.begin());
  std::copy_n(cameras.translation.val, 3, stand.translation.begin());
  return make_calibration(size.width, size.height, raw, stand);
}

/// How far apart the rows of the same corner are in the rectified views, px.
std::vector<double> row_distances(const Calibration& c, const View& view) {
  std::vector<cv::Point2f> rectified[2];
  for (int i : {0, 1}) {
    const RawCamera& camera = (*c.raw)[i];
    cv::undistortPoints(view.board[i].corners, rectified[i], cv::Matx33d(camera.k.data()), cv::Mat(camera.distortion, true),
                        cv::Matx33d(camera.rectification.data()), cv::Matx34d(camera.projection.data()));
  }
  std::vector<double> distances;
  for (size_t n = 0; n < rectified[0].size(); ++n) distances.push_back(std::abs(rectified[0][n].y - rectified[1][n].y));
  return distances;
}

void measure_rows(Solution& solution, const Lists& lists) {
  std::vector<double> all;
  for (View* view : lists.views) {
    const auto distances = row_distances(solution.calibration, *view);
    view->rows = median(distances);
    all.insert(all.end(), distances.begin(), distances.end());
  }
  solution.rows_median = median(all);
  std::sort(all.begin(), all.end());
  solution.rows_p95 = all[all.size() * 95 / 100];
}

}  // namespace

Solution solve_stereo(const Board& board, const cv::Size& size, std::vector<View>& views, double most_rms) {
  const auto usable = std::count_if(views.begin(), views.end(), [](const View& view) { return view.used(); });
  if (usable < fewest_views)
    throw ToolError(EX_NOINPUT, "the board is seen by both cameras in " + std::to_string(usable) + " of " + std::to_string(views.size()) +
                                    " pairs, needed are " + std::to_string(fewest_views) + ", better 15");
  size_t may_go = std::min(static_cast<size_t>(usable) / 4, static_cast<size_t>(usable - fewest_views));
  for (;;) {
    const Lists lists = lists_of(board, views);
    const Cameras cameras = calibrate(lists, size);
    for (size_t n = 0; n < lists.views.size(); ++n) measure_view(cameras, n, lists.places[n], *lists.views[n]);
    const size_t before = lists.views.size();
    if (may_go > 0 && reject_worst(lists, may_go)) {
      may_go -= before - lists_of(board, views).views.size();
      continue;
    }
    Solution solution;
    solution.size = size;
    solution.rms = cameras.rms;
    solution.f_deviation = cameras.f_deviation;
    try {
      solution.calibration = calibration_of(cameras, size);
      measure_rows(solution, lists);
    } catch (const CalibrationError& error) {
      solution.faults.push_back(std::string("the views do not tell where the cameras are (") + error.what() + ")");
    }
    judge(solution, views, most_rms);
    if ((cameras.rotation.t() * cameras.translation)[0] > 0) {
      solution.faults = {"the right camera lies left of the left one: the views are exchanged"};
      solution.advice = {"LEFT and RIGHT the other way round"};
    }
    if (!solution.calibration.raw) throw ToolError(EX_CONFIG, refusal(solution));
    return solution;
  }
}

}  // namespace vdisp::calibrate
