// stereo.cpp: StereoBM, StereoSGBM, and the cloud.
// SPDX-License-Identifier: Apache-2.0
#include "tests/peers/stereo.h"

#include <cmath>
#include <opencv2/calib3d.hpp>

namespace peers {
namespace {
cv::Mat block_matching(const Search& search, const cv::Mat& left, const cv::Mat& right) {
  const auto matcher = cv::StereoBM::create(search.disparities, 11);
  matcher->setPreFilterType(cv::StereoBM::PREFILTER_XSOBEL);
  matcher->setPreFilterCap(31);
  matcher->setTextureThreshold(10);
  matcher->setUniquenessRatio(10);
  matcher->setDisp12MaxDiff(1);
  cv::Mat disparity;
  matcher->compute(left, right, disparity);
  // Its own filter counts in 1/16 px, and would take away whatever is slanted.
  cv::filterSpeckles(disparity, -16, search.speckle, 16);
  return disparity;
}

cv::Mat semi_global(const Search& search, const cv::Mat& left, const cv::Mat& right) {
  cv::Mat disparity;
  cv::StereoSGBM::create(0, search.disparities, 5, 200, 800, 1, 63, 10, search.speckle, 1, cv::StereoSGBM::MODE_SGBM_3WAY)
      ->compute(left, right, disparity);
  return disparity;
}
}  // namespace

cv::Mat match(const std::string& matcher, const Search& search, const cv::Mat& left, const cv::Mat& right) {
  return matcher == "StereoBM" ? block_matching(search, left, right) : semi_global(search, left, right);
}

Cloud::Ptr point_cloud(const cv::Mat& disparity, const Camera& camera, const Mounting& mounting, const Area& area) {
  Cloud::Ptr cloud(new Cloud);
  cloud->reserve(disparity.total());
  const float sin = std::sin(mounting.pitch), cos = std::cos(mounting.pitch);
  for (int v = 0; v < disparity.rows; ++v) {
    const auto* row = disparity.ptr<int16_t>(v);
    for (int u = 0; u < disparity.cols; ++u) {
      const float d = static_cast<float>(row[u]) / 16 - camera.cx_offset;
      if (row[u] <= 0 || d <= 0) continue;
      const float z = camera.f * camera.baseline / d;
      const float x = (static_cast<float>(u) - camera.cx) * z / camera.f, y = (static_cast<float>(v) - camera.cy) * z / camera.f;
      const pcl::PointXYZ point(z * cos - y * sin, -x, mounting.height - (y * cos + z * sin));
      if (point.x <= area.range && std::abs(point.y) <= area.width / 2 && point.z > -1 && point.z < area.most + 1) cloud->push_back(point);
    }
  }
  return cloud;
}
}  // namespace peers
