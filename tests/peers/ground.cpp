// ground.cpp: voxels, plane with normals, progressive morphological filter.
// SPDX-License-Identifier: Apache-2.0
#include "tests/peers/ground.h"

#include <pcl/features/normal_3d.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/search/kdtree.h>
#include <pcl/segmentation/approximate_progressive_morphological_filter.h>
#include <pcl/segmentation/sac_segmentation.h>

#include <cmath>

namespace peers {
Cloud::Ptr thin(const Cloud::Ptr& cloud, const Area& area, const Filters& filters) {
  pcl::VoxelGrid<pcl::PointXYZ> grid;
  const float leaf = filters.leaf * area.cell;
  grid.setInputCloud(cloud);
  grid.setLeafSize(leaf, leaf, leaf);
  grid.setMinimumPointsNumberPerVoxel(filters.voxel_points);
  Cloud::Ptr thinned(new Cloud);
  grid.filter(*thinned);
  return thinned;
}

Cloud::Ptr above_plane(const Cloud::Ptr& cloud, const Area& area, const Filters& filters) {
  Cloud::Ptr obstacles(new Cloud), low(new Cloud);
  // PCL cannot be told how far the plane is from the camera, so it is sought where the mounting says that it is.
  for (const auto& point : *cloud)
    if (std::abs(point.z) < filters.band * area.least) low->push_back(point);
  if (low->size() < 3) return obstacles;
  pcl::NormalEstimation<pcl::PointXYZ, pcl::Normal> estimation;
  pcl::PointCloud<pcl::Normal>::Ptr normals(new pcl::PointCloud<pcl::Normal>);
  estimation.setInputCloud(low);
  estimation.setSearchMethod(pcl::search::KdTree<pcl::PointXYZ>::Ptr(new pcl::search::KdTree<pcl::PointXYZ>));
  estimation.setKSearch(filters.neighbours);
  estimation.compute(*normals);

  pcl::SACSegmentationFromNormals<pcl::PointXYZ, pcl::Normal> segmentation;
  segmentation.setModelType(pcl::SACMODEL_NORMAL_PARALLEL_PLANE);
  segmentation.setMethodType(pcl::SAC_RANSAC);
  segmentation.setOptimizeCoefficients(true);
  segmentation.setNormalDistanceWeight(filters.normal_weight);
  segmentation.setMaxIterations(1000);
  segmentation.setDistanceThreshold(filters.reach * area.least);
  segmentation.setAxis(Eigen::Vector3f::UnitZ());
  segmentation.setEpsAngle(filters.tilt);
  segmentation.setInputCloud(low);
  segmentation.setInputNormals(normals);
  pcl::PointIndices inliers;
  pcl::ModelCoefficients plane;
  segmentation.segment(inliers, plane);
  if (inliers.indices.empty()) return obstacles;
  const float sign = plane.values[2] < 0 ? -1.0F : 1.0F;
  for (const auto& point : *cloud) {
    const float over = sign * (plane.values[0] * point.x + plane.values[1] * point.y + plane.values[2] * point.z + plane.values[3]);
    if (over > area.least && over < area.most) obstacles->push_back(point);
  }
  return obstacles;
}

Cloud::Ptr not_ground(const Cloud::Ptr& cloud, const Area& area, const Filters& filters) {
  Cloud::Ptr obstacles(new Cloud);
  if (cloud->empty()) return obstacles;
  pcl::ApproximateProgressiveMorphologicalFilter<pcl::PointXYZ> filter;
  filter.setInputCloud(cloud);
  filter.setMaxWindowSize(filters.window);
  filter.setSlope(filters.slope);
  filter.setInitialDistance(filters.step * area.least);
  filter.setMaxDistance(filters.step * area.least);
  filter.setCellSize(area.cell);
  filter.setNumberOfThreads(1);
  pcl::Indices ground;
  filter.extract(ground);
  std::vector<bool> is_ground(cloud->size());
  for (const auto i : ground) is_ground[static_cast<size_t>(i)] = true;
  for (size_t i = 0; i < cloud->size(); ++i)
    if (!is_ground[i] && (*cloud)[i].z < area.most) obstacles->push_back((*cloud)[i]);
  return obstacles;
}
}  // namespace peers
