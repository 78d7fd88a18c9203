// misalignment_test.cpp: a right camera that stands differently by a known amount is measured by the rows of matches, one motion at a time.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/tools/calibrate/misalignment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "daemon/geometry/calibration.h"

namespace vdisp::calibrate {
namespace {

constexpr StereoView view{500, 320, 240, 0.1, 4};

/// Points at random depths seen by a left camera and by a right one that is turned by `turn`; a fifth of the matches are wrong.
std::vector<RowMatch> matches(const cv::Vec3d& turn, double shift = 0, double scale = 1) {
  std::minstd_rand random(7);
  const auto draw = [&random](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  cv::Matx33d rotation;
  cv::Rodrigues(turn, rotation);
  std::vector<RowMatch> all;
  for (int i = 0; i < 500; ++i) {
    const double u = draw(40, 600), v = draw(20, 460), z = draw(0.8, 10);
    const cv::Vec3d point((u - view.cx) / view.f * z - view.baseline, (v - view.cy) / view.f * z, z);
    const cv::Vec3d seen = rotation * point;
    const double x = scale * view.f * seen[0] / seen[2] + view.cx - view.cx_offset,
                 y = scale * view.f * seen[1] / seen[2] + view.cy + shift;
    const double wrong = i % 5 == 0 ? draw(-30, 30) : std::normal_distribution(0.0, 0.1)(random);
    all.push_back(
        {cv::Point2f(static_cast<float>(u), static_cast<float>(v)), cv::Point2f(static_cast<float>(x), static_cast<float>(y + wrong))});
  }
  return all;
}

TEST(Misalignment, good_rows_have_none) {
  const Misalignment m = fit_misalignment(matches({}), view);
  EXPECT_LT(m.median_px, 0.15);
  EXPECT_NEAR(m.shift_px, 0, 0.05);
  EXPECT_NEAR(m.roll_rad, 0, 3e-4);
  EXPECT_NEAR(m.yaw_rad, 0, 1e-3);
  EXPECT_NEAR(m.scale, 0, 5e-4);
}

TEST(Misalignment, a_shift_is_that_and_nothing_else) {
  const Misalignment m = fit_misalignment(matches({}, 2), view);
  EXPECT_NEAR(m.shift_px, 2, 0.05);
  EXPECT_NEAR(m.roll_rad, 0, 3e-4);
  EXPECT_NEAR(m.scale, 0, 5e-4);
  EXPECT_LT(m.remaining_px, 0.15);
}

TEST(Misalignment, each_axis_of_rotation_has_its_own_pattern) {
  constexpr double half = 0.5 * 3.14159265 / 180;
  const Misalignment z = fit_misalignment(matches({0, 0, half}), view);
  EXPECT_NEAR(z.roll_rad, half, 0.03 * half);
  EXPECT_NEAR(z.yaw_rad, 0, 1e-3);
  const Misalignment y = fit_misalignment(matches({0, half, 0}), view);
  EXPECT_NEAR(y.yaw_rad, half, 0.1 * half);
  EXPECT_NEAR(y.roll_rad, 0, 3e-4);
  const Misalignment x = fit_misalignment(matches({half, 0, 0}), view);
  EXPECT_NEAR(x.shift_px, -view.f * std::tan(half), 0.05);
  EXPECT_NEAR(x.scale, 0, 1e-3);
}

TEST(Misalignment, a_larger_right_view_is_a_scale) { EXPECT_NEAR(fit_misalignment(matches({}, 0, 1.01), view).scale, 0.01, 5e-4); }

/// A random texture moved by a known fraction of a pixel, in 32nds, as warpAffine counts.
TEST(RowMatches, find_the_shift_of_a_texture_to_a_twentieth_of_a_pixel) {
  cv::Mat noise(400, 560, CV_8U), blurred, left, right;
  cv::RNG random(3);
  random.fill(noise, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(noise, blurred, {0, 0}, 1.5);
  cv::normalize(blurred, blurred, 0, 255, cv::NORM_MINMAX);
  const auto moved = [&blurred](double x, double y, cv::Mat& out) {
    cv::warpAffine(blurred, out, cv::Matx23d(1, 0, x, 0, 1, y), {480, 360}, cv::INTER_CUBIC);
  };
  moved(-40, -20, left);
  for (const auto& [x, y] : {std::pair{-12.25, 1.75}, {17.625, -0.375}, {-30.0, -25.25}}) {
    moved(-40 + x, -20 + y, right);
    const auto found = match_rows(left, right);
    ASSERT_GT(found.size(), 40u) << x << ' ' << y;
    double rows = 0, disparity = 0;
    for (const RowMatch& match : found) rows += match.rows(), disparity += match.disparity();
    EXPECT_NEAR(rows / static_cast<double>(found.size()), y, 0.05);
    EXPECT_NEAR(disparity / static_cast<double>(found.size()), -x, 0.05);
  }
}

TEST(RowMatches, a_view_without_texture_has_none) {
  EXPECT_TRUE(match_rows(cv::Mat(360, 480, CV_8U, cv::Scalar(128)), cv::Mat(360, 480, CV_8U, cv::Scalar(128))).empty());
}

/// The set's makers rectified at full size, 1920x1200, and put three by three pixels into one; their projection is told for the thirds.
TEST(RealSets, rover_minnie_is_rectified_to_the_same_rows_as_by_its_makers) {
  const std::filesystem::path set = std::filesystem::path(VDISP_SHARED_DATA) / "rover_minnie";
  if (!std::filesystem::exists(set)) GTEST_SKIP() << "no " << set;
  const Calibration ours = read_calibration(set / "raw/calibration_opencv.yml");
  const StereoView theirs = read_calibration(set / "rectified/calibration.yml").view;
  const cv::Matx33d camera(3 * theirs.f, 0, 3 * theirs.cx, 0, 3 * theirs.f, 3 * theirs.cy, 0, 0, 1);
  for (const char* name : {"000000.png", "000001.png"})
    for (size_t side : {0u, 1u}) {
      const std::string folder = side == 0 ? "left" : "right";
      const cv::Mat raw = cv::imread((set / "raw" / folder / name).string(), cv::IMREAD_GRAYSCALE);
      const cv::Mat wanted = cv::imread((set / "rectified" / folder / name).string(), cv::IMREAD_GRAYSCALE);
      const RawCamera& c = (*ours.raw)[side];
      cv::Mat map_x, map_y, whole, third;
      cv::initUndistortRectifyMap(cv::Matx33d(c.k.data()), cv::Mat(c.distortion, true), cv::Matx33d(c.rectification.data()), camera,
                                  raw.size(), CV_32FC1, map_x, map_y);
      cv::remap(raw, whole, map_x, map_y, cv::INTER_LINEAR);
      cv::resize(whole, third, wanted.size(), 0, 0, cv::INTER_AREA);
      std::vector<double> rows;
      for (const RowMatch& match : match_rows(wanted, third)) rows.push_back(std::abs(match.rows()));
      ASSERT_GT(rows.size(), 100u);
      std::nth_element(rows.begin(), rows.begin() + rows.size() / 2, rows.end());
      EXPECT_LT(rows[rows.size() / 2], 0.3) << folder << name;
      std::printf("%s %s: rows of %zu matches differ by %.3f px (median)\n", folder.c_str(), name, rows.size(), rows[rows.size() / 2]);
    }
}

}  // namespace
}  // namespace vdisp::calibrate
