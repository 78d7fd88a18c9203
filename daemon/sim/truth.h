// truth.h: the stages truth/...: what the tree should have found, from the simulator's world, never from the tree.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "config/config.h"
#include "daemon/core/driver.h"
#include "daemon/sim/simulator.h"

namespace vdisp::sim {

/// Adds truth/disparity, truth/object, truth/height, truth/scene, truth/floor, truth/map and truth/map_cells, and in a world
/// truth/steering. `camera` is the left
/// raw image, whose time tells the frame. Simulator and configuration must outlive the driver's last step.
void add_truth_stages(Driver& driver, Handle camera, Simulator& simulator, const Config& config);

}  // namespace vdisp::sim
