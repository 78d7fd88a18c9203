// dump_json.h: the members of a dump's frame.json.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>

#include "ipc/image.h"
#include "ipc/records.h"

namespace vdisp {

/// `floor`, of an image that holds a FloorModel. Blind, its bytes are those of some earlier frame: nothing of them is told.
nlohmann::ordered_json floor_json(const Image& image);
/// in/odometry, in/imu, in/drive or in/event. Blind, only what became of its messages is told.
nlohmann::ordered_json input_json(const Image& image);
/// How many pixels of `surface` were filled.
uint64_t filled_pixels(const Image& surface);
nlohmann::ordered_json scene_json(const TruthScene& scene);
/// `map_changes`. The cells are not told: `occupancy` of the same frame is there.
nlohmann::ordered_json changes_json(const MapChanges& changes);
nlohmann::ordered_json memory_json(const Memory& memory);
nlohmann::ordered_json tracks_json(const Tracks& tracks);
nlohmann::ordered_json scores_json(const SnowScores& scores);
nlohmann::ordered_json decision_json(const Decision& decision);
nlohmann::ordered_json command_json(const DriveCommand& command);
nlohmann::ordered_json check_json(const CrossCheck& check);
/// `camera/status`, as the member `camera_status`.
nlohmann::ordered_json cameras_json(const CameraStatus& status);
nlohmann::ordered_json camera_json(const CameraGeometry& camera);
nlohmann::ordered_json grid_json(const GridGeometry& grid);

/// Code of a pixel in STAGE_reason.png, 0 where STAGE.png has a value: as rejected_code(), but a disparity that is not above 0
/// cannot be told from none there, and counts as Rejected::infinity.
uint8_t dumped_code(int16_t disparity);
/// How many pixels of a disparity image have each code.
nlohmann::ordered_json rejected_json(const Image& image);

}  // namespace vdisp
