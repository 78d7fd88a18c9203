// stereo.h: the stereo half of the peers: OpenCV's matchers, and the point cloud of their disparities.
// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <opencv2/core.hpp>
#include <string>

namespace peers {
using Cloud = pcl::PointCloud<pcl::PointXYZ>;

struct Camera {
  float f, cx, cy, baseline, cx_offset;  ///< pixels, and m for the baseline; as frame.json of a dump has them
};
/// What is known of the camera's place, as an operator measures it: m, and rad with positive looking down.
struct Mounting {
  float height = 1.65F, pitch = 0;
};
/// The box of ground that the map covers, and the heights in which something is an obstacle, m.
struct Area {
  float range = 20, width = 16, cell = 0.5F, least = 0.4F, most = 2.2F;
};

/// What is told to OpenCV's matchers; all else is as in the bench.
struct Search {
  int disparities = 128, speckle = 100;  ///< pixels: what is searched, and the largest area that is refused as a speckle
};

/// Disparities in 1/16 px, 16 bit; what is not above 0 is none. `matcher`: StereoBM or StereoSGBM.
cv::Mat match(const std::string& matcher, const Search& search, const cv::Mat& left, const cv::Mat& right);

/// Points in the rover frame (x ahead, y left, z above the ground that the mounting tells), cut to the area and to 1 m below the ground.
Cloud::Ptr point_cloud(const cv::Mat& disparity, const Camera& camera, const Mounting& mounting, const Area& area);
}  // namespace peers
