// sim.h: the simulator as a stereo camera.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "daemon/sources/source.h"

namespace vdisp {

/// Where the renderer is looked for, in this order: beside the program, in ../lib/vdisp beside it, where it is installed.
std::vector<std::filesystem::path> simulator_places();

/// Loads the renderer from the first of these places that has it. Throws SourceError 69 where it is in none or does not start,
/// and 78 where [image source] asks for another size than [sim]. The configuration must outlive the source.
std::unique_ptr<StereoSource> open_sim(const Config& config, const std::vector<std::filesystem::path>& places);
inline std::unique_ptr<StereoSource> open_sim(const Config& config) { return open_sim(config, simulator_places()); }

}  // namespace vdisp
