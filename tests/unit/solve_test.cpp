// solve_test.cpp: cameras that are known exactly are found again from pictures of boards; views and results that are not good are refused.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <opencv2/aruco/charuco.hpp>

#include "daemon/geometry/calibration_write.h"
#include "daemon/tools/calibrate/judgement.h"
#include "daemon/tools/calibrate/rotation.h"
#include "daemon/tools/calibrate/stereo_solution.h"
#include "tests/unit/board_pictures.h"

namespace vdisp::calibrate {
namespace {

const cv::Size size(640, 480);
const TrueCamera cameras[2] = {{{532, 0, 326, 0, 534, 236, 0, 0, 1}, {-0.25, 0.09, 0.0006, -0.0004, 0}},
                               {{527, 0, 315, 0, 529, 246, 0, 0, 1}, {-0.24, 0.08, -0.0005, 0.0003, 0}}};
const cv::Vec3d true_turn(0.012, -0.021, 0.008), true_shift(-0.12, 0.0015, -0.001);
constexpr double degrees = 180 / std::numbers::pi;

BoardOptions options(const std::string& text = "9x6", const std::string& kind = "chessboard") {
  BoardOptions board;
  board.size = text, board.square_m = 0.03, board.kind = kind;
  return board;
}

/// Where the board's middle is seen (fraction of the view from its middle), how far, and how it is turned.
struct Pose {
  double x, y, z, across, down, around;
};
const Pose poses[] = {{0, 0, 0.5, 0, 0, 0},
                      {-0.15, -0.15, 0.6, 0.5, 0.1, 0},
                      {0.15, -0.15, 0.6, -0.5, 0.1, 0.1},
                      {-0.15, 0.15, 0.6, 0.4, -0.4, 0},
                      {0.15, 0.15, 0.6, -0.4, -0.4, -0.1},
                      {0, 0.15, 0.6, 0, 0.6, 0.2},
                      {0, -0.15, 0.6, 0, -0.6, -0.2},
                      {-0.25, 0, 0.8, 0.7, 0, 0},
                      {0.25, 0, 0.8, -0.7, 0, 0},
                      {-0.27, -0.28, 0.85, -0.3, 0.3, 0},
                      {0.27, -0.28, 0.85, 0.3, 0.3, 0},
                      {-0.27, 0.28, 0.85, -0.3, -0.3, 0.1},
                      {0.27, 0.28, 0.85, 0.3, -0.3, -0.1},
                      {0.05, 0.05, 0.9, 0.5, 0.5, 0}};

struct Stage {
  TrueBoard board{9, 6, 0.03};
  TrueView views[2] = {{cameras[0], size}, {cameras[1], size}};

  std::array<cv::Mat, 2> pair(const Pose& pose, unsigned seed) const {
    cv::Matx33d across, down, around, right;
    cv::Rodrigues(cv::Vec3d(0, pose.across, 0), across);
    cv::Rodrigues(cv::Vec3d(pose.down, 0, 0), down);
    cv::Rodrigues(cv::Vec3d(0, 0, pose.around), around);
    cv::Rodrigues(true_turn, right);
    const cv::Matx33d rotation = across * down * around;
    const cv::Vec3d middle(0.5 * (board.columns - 1) * board.square, 0.5 * (board.rows - 1) * board.square, 0);
    const cv::Vec3d shift = cv::Vec3d(pose.x * pose.z * 1.2 + 0.06, pose.y * pose.z * 0.9, pose.z) - rotation * middle;
    return {views[0].of(board, rotation, shift, seed), views[1].of(board, right * rotation, right * shift + true_shift, seed + 1000)};
  }
};
const Stage& stage() {
  static const Stage made;
  return made;
}

View look(const Board& board, const std::array<cv::Mat, 2>& images, const std::string& name) {
  View view;
  view.left = view.right = name;
  for (int i : {0, 1}) view.board[static_cast<size_t>(i)] = board.find(images[static_cast<size_t>(i)]);
  if (view.board[0].empty() || view.board[1].empty()) {
    view.rejected = "no board found";
    return view;
  }
  board.agree(view.board[0], view.board[1]);
  keep_common(view.board[0], view.board[1]);
  return view;
}

std::vector<View> all_views(const Board& board) {
  std::vector<View> views;
  for (const Pose& pose : poses)
    views.push_back(look(board, stage().pair(pose, static_cast<unsigned>(views.size()) + 1), std::to_string(views.size())));
  return views;
}
const std::vector<View>& seen() {
  static const std::vector<View> views = all_views(Board(options()));
  return views;
}

double relative(double found, double truth) { return std::abs(found / truth - 1); }

TEST(Solve, finds_known_cameras_again) {
  std::vector<View> views = seen();
  const Solution solution = solve_stereo(Board(options()), size, views, 0.5);
  EXPECT_TRUE(solution.faults.empty()) << solution.faults.at(0);
  for (const View& view : views) EXPECT_TRUE(view.used()) << view.left << ": " << view.rejected;
  for (int i : {0, 1}) {
    const auto& k = (*solution.calibration.raw)[static_cast<size_t>(i)].k;
    EXPECT_LT(relative(k[0], cameras[i].k(0, 0)), 0.001) << k[0];
    EXPECT_LT(relative(k[4], cameras[i].k(1, 1)), 0.001) << k[4];
  }
  const Stand stand = stand_of(solution.calibration);
  EXPECT_LT(relative(solution.calibration.view.baseline, cv::norm(true_shift)), 0.002) << solution.calibration.view.baseline;
  cv::Matx33d truth;
  cv::Rodrigues(true_turn, truth);
  cv::Vec3d difference;
  cv::Rodrigues(cv::Matx33d(stand.rotation.data()) * truth.t(), difference);
  EXPECT_LT(degrees * cv::norm(difference), 0.02);
  EXPECT_LT(solution.rms, 0.1);
  EXPECT_LT(solution.rows_median, 0.1);
  std::printf("f off by %.4f %%, baseline by %.4f %%, rotation by %.4f deg, rms %.3f px, rows %.3f px, f known to %.3f %%\n",
              100 * relative((*solution.calibration.raw)[0].k[0], 532),
              100 * relative(solution.calibration.view.baseline, cv::norm(true_shift)), degrees * cv::norm(difference), solution.rms,
              solution.rows_median, 100 * solution.f_deviation);
}

TEST(Solve, rejects_the_view_whose_board_moved_between_left_and_right) {
  std::vector<View> views = seen();
  for (cv::Point2f& corner : views[4].board[1].corners) corner += cv::Point2f(3, 2);
  const Solution solution = solve_stereo(Board(options()), size, views, 0.5);
  EXPECT_TRUE(solution.faults.empty());
  EXPECT_NE(views[4].rejected.find("px from where they should be"), std::string::npos) << views[4].rejected;
  for (size_t i = 0; i < views.size(); ++i) EXPECT_EQ(views[i].used(), i != 4) << i;
  EXPECT_LT(relative(solution.calibration.view.baseline, cv::norm(true_shift)), 0.002);
}

TEST(Solve, refuses_views_that_show_the_board_from_one_side_only_and_says_which_to_add) {
  const Board board(options());
  std::vector<View> views;
  for (unsigned i = 0; i < 6; ++i) views.push_back(look(board, stage().pair({0.01 * i, 0, 0.9, 0.02 * i, 0, 0}, i + 50), "flat"));
  std::string said;
  try {
    said = refusal(solve_stereo(board, size, views, 0.5));
  } catch (const ToolError& error) {
    EXPECT_EQ(error.exit_code, 78);
    said = error.what();
  }
  for (const char* words : {"not usable", "upper left", "lower right", "turned to one side", "tilted forward", "6 are used"})
    EXPECT_NE(said.find(words), std::string::npos) << words << " in\n" << said;
}

TEST(Solve, too_few_views_are_refused) {
  std::vector<View> views(seen().begin(), seen().begin() + 4);
  try {
    solve_stereo(Board(options()), size, views, 0.5);
    FAIL() << "taken";
  } catch (const ToolError& error) {
    EXPECT_EQ(error.exit_code, 66);
    EXPECT_NE(std::string(error.what()).find("4 of 4 pairs, needed are 5"), std::string::npos) << error.what();
  }
}

TEST(Solve, a_board_that_is_another_one_is_not_found) {
  EXPECT_TRUE(Board(options("8x5")).find(stage().pair(poses[0], 1)[0]).empty());
  EXPECT_TRUE(Board(options()).find(cv::Mat(size, CV_8U, cv::Scalar(128))).empty());
}

TEST(Boards, corners_are_found_to_a_tenth_of_a_pixel) {
  const auto images = stage().pair(poses[0], 1);
  const BoardView view = Board(options()).find(images[0]);
  ASSERT_FALSE(view.empty());
  const Board board(options());
  std::vector<cv::Point2f> expected;
  const cv::Vec3d shift(0.06 - 4 * 0.03, -2.5 * 0.03, 0.5);
  cv::projectPoints(board.places(view.ids), cv::Vec3d(), shift, cameras[0].k, cameras[0].distortion, expected);
  double sum = 0;
  for (size_t i = 0; i < expected.size(); ++i) {
    double nearest = 1e9;
    for (const cv::Point2f& corner : view.corners) nearest = std::min(nearest, cv::norm(corner - expected[i]));
    sum += nearest * nearest;
  }
  EXPECT_LT(std::sqrt(sum / 54), 0.1);
}

TEST(Boards, a_charuco_board_is_found_with_a_part_of_it_hidden) {
  const Board board(options("8x6", "charuco"));
  const auto dictionary = cv::aruco::getPredefinedDictionary(cv::aruco::DICT_5X5_100);
  cv::Mat image;
  cv::aruco::CharucoBoard::create(8, 6, 0.03f, 0.0225f, dictionary)->draw({640, 480}, image, 20);
  const BoardView whole = board.find(image);
  EXPECT_EQ(whole.ids.size(), 35u);
  image(cv::Rect(0, 0, 260, 480)).setTo(90);
  const BoardView part = board.find(image);
  EXPECT_GE(part.ids.size(), 12u);
  EXPECT_LT(part.ids.size(), 35u);
  for (size_t i = 0; i < part.ids.size(); ++i) {
    const auto found = std::find(whole.ids.begin(), whole.ids.end(), part.ids[i]);
    ASSERT_NE(found, whole.ids.end());
    EXPECT_LT(cv::norm(part.corners[i] - whole.corners[static_cast<size_t>(found - whole.ids.begin())]), 0.2);
  }
}

TEST(Boards, wrong_descriptions_are_refused) {
  for (const char* wrong : {"9", "9x", "x6", "9x6x3", "1x6", "-9x6", "999x999"}) EXPECT_THROW(Board(options(wrong)), ToolError) << wrong;
  BoardOptions charuco = options("8x6", "charuco");
  charuco.dictionary = "DICT_9X9";
  EXPECT_THROW(Board{charuco}, ToolError);
}

TEST(Rotation, axis_times_angle_is_what_it_was_made_of) {
  cv::Matx33d r;
  cv::Rodrigues(cv::Vec3d(0.3, -0.2, 0.1), r);
  const auto found = rotation_vector({r(0, 0), r(0, 1), r(0, 2), r(1, 0), r(1, 1), r(1, 2), r(2, 0), r(2, 1), r(2, 2)});
  EXPECT_NEAR(found[0], 0.3, 1e-12);
  EXPECT_NEAR(found[1], -0.2, 1e-12);
  EXPECT_NEAR(found[2], 0.1, 1e-12);
}

}  // namespace
}  // namespace vdisp::calibrate
