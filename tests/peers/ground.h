// ground.h: the ground half of the peers: which points of a cloud are obstacles, by PCL.
// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "tests/peers/stereo.h"

namespace peers {
/// Settings of the filters, in units of the area: lengths scale with its cell and its least height.
struct Filters {
  float leaf = 0.2F;          ///< voxel, of a cell
  unsigned voxel_points = 2;  ///< fewest points of a voxel
  float band = 2;             ///< plane: how far below and above the mounting's ground it is sought, of `least`
  float reach = 0.5F;         ///< plane: distance of its points, of `least`
  float normal_weight = 0.1F;
  int neighbours = 20;  ///< of a normal
  float tilt = 0.17F;   ///< plane: most against the mounting's, rad
  int window = 20;      ///< morphological: largest, in its cells
  float slope = 0.3F;   ///< morphological: steepest ground
  float step = 1;       ///< morphological: most that ground may stand over the opened surface, of `least`
  int cell_voxels = 3;  ///< fewest voxels that make a cell an obstacle
};

/// Fewer points of about equal density (pcl::VoxelGrid).
Cloud::Ptr thin(const Cloud::Ptr& cloud, const Area& area, const Filters& filters);

/// Obstacles are `least` to `most` above a plane by RANSAC on points and normals (SACSegmentationFromNormals), level within `tilt`.
Cloud::Ptr above_plane(const Cloud::Ptr& cloud, const Area& area, const Filters& filters);

/// Obstacles are what the progressive morphological filter does not take for ground, up to `most` over the mounting's ground.
Cloud::Ptr not_ground(const Cloud::Ptr& cloud, const Area& area, const Filters& filters);
}  // namespace peers
