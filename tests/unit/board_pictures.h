// board_pictures.h: pairs of images of a chessboard by two cameras that are known exactly: rays of sub-pixels meet the board's plane.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

namespace vdisp {

struct TrueCamera {
  cv::Matx33d k;
  cv::Vec<double, 5> distortion;
};

/// A chessboard of inner corners `columns` x `rows`, with a white margin of a square's width.
struct TrueBoard {
  int columns, rows;
  double square;
  /// Brightness at a place of the board, m from the first inner corner.
  double at(double x, double y) const {
    const double column = x / square, row = y / square;
    if (column < -2 || row < -2 || column > columns + 1 || row > rows + 1) return 0.45;
    if (column < -1 || row < -1 || column > columns || row > rows) return 0.9;
    return (static_cast<int>(std::floor(column)) + static_cast<int>(std::floor(row))) & 1 ? 0.1 : 0.9;
  }
};

class TrueView {
 public:
  static constexpr int fine = 16;      ///< rays across a pixel that an edge goes through
  static constexpr double blur = 0.7;  ///< px, of the lens

  TrueView(const TrueCamera& camera, const cv::Size& size) : size_(size) {
    std::vector<cv::Point2d> corners;
    for (int y = 0; y <= size.height; ++y)
      for (int x = 0; x <= size.width; ++x) corners.emplace_back(x - 0.5, y - 0.5);
    cv::undistortPoints(corners, rays_, camera.k, camera.distortion, cv::noArray(), cv::noArray(), {cv::TermCriteria::COUNT, 40, 0});
  }

  /// The board stands where rotation and shift (board to camera) put it. Noise of 1 grey level.
  cv::Mat of(const TrueBoard& board, const cv::Matx33d& rotation, const cv::Vec3d& shift, unsigned seed) const {
    // A ray r meets the plane at H r = (x, y, 1) up to scale, with H the inverse of (first and second column of the rotation, shift).
    const cv::Matx33d h = cv::Matx33d(rotation(0, 0), rotation(0, 1), shift[0], rotation(1, 0), rotation(1, 1), shift[1], rotation(2, 0),
                                      rotation(2, 1), shift[2])
                              .inv();
    std::minstd_rand random(seed);
    std::normal_distribution<double> noise(0, 1);
    cv::Mat image(size_, CV_32F), seen(size_, CV_8U);
    for (int y = 0; y < size_.height; ++y)
      for (int x = 0; x < size_.width; ++x) image.at<float>(y, x) = static_cast<float>(255 * pixel(board, h, x, y));
    cv::GaussianBlur(image, image, {0, 0}, blur);
    for (int y = 0; y < size_.height; ++y)
      for (int x = 0; x < size_.width; ++x) seen.at<uint8_t>(y, x) = cv::saturate_cast<uint8_t>(image.at<float>(y, x) + noise(random));
    return seen;
  }

 private:
  const cv::Point2d& ray(int x, int y) const { return rays_[static_cast<size_t>(y * (size_.width + 1) + x)]; }
  static cv::Point2d meet(const cv::Matx33d& h, const cv::Point2d& r) {
    const double w = h(2, 0) * r.x + h(2, 1) * r.y + h(2, 2);
    return {(h(0, 0) * r.x + h(0, 1) * r.y + h(0, 2)) / w, (h(1, 0) * r.x + h(1, 1) * r.y + h(1, 2)) / w};
  }

  /// Within a pixel rays lie between those of its corners.
  double pixel(const TrueBoard& board, const cv::Matx33d& h, int x, int y) const {
    const cv::Point2d a = ray(x, y), b = ray(x + 1, y), c = ray(x, y + 1), d = ray(x + 1, y + 1);
    const auto square = [&](const cv::Point2d& r) {
      const cv::Point2d at = meet(h, r);
      return cv::Point(cvFloor(at.x / board.square), cvFloor(at.y / board.square));
    };
    const cv::Point first = square(a);
    if (square(b) == first && square(c) == first && square(d) == first) {
      const cv::Point2d at = meet(h, a);
      return board.at(at.x, at.y);
    }
    double sum = 0;
    for (int i = 0; i < fine; ++i)
      for (int j = 0; j < fine; ++j) {
        const double down = (i + 0.5) / fine, across = (j + 0.5) / fine;
        const cv::Point2d at = meet(h, (1 - down) * ((1 - across) * a + across * b) + down * ((1 - across) * c + across * d));
        sum += board.at(at.x, at.y);
      }
    return sum / (fine * fine);
  }

  cv::Size size_;
  std::vector<cv::Point2d> rays_;
};

}  // namespace vdisp
