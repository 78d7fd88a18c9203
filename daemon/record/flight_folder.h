// flight_folder.h: the folders that the flight recorder writes: names, how many are kept, and whether there is room for one more.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "ipc/records.h"

namespace vdisp {

struct FlightRoom {
  std::filesystem::path folder;  ///< [recorder] folder
  int keep = 1;                  ///< folders, the new one among them
  uint64_t least_free = 0;       ///< bytes that must stay free on the disk
};

/// A new name in it: flight-20260131-235959-123-floor_lost, UTC and ms. Throws WriteError: 73 no folder, 74 fewer bytes free than `needed`
/// and those that must stay.
std::filesystem::path find_flight_folder(const FlightRoom& room, FlightCause cause, uint64_t needed);
/// When the folder `whole` is written: the oldest others are deleted, so that no more than `keep` are there. What is not called so is left
/// alone.
void drop_oldest(const FlightRoom& room, const std::filesystem::path& whole);
/// When writing `folder` failed: it stays while there is a place for it beside those that are whole.
void drop_broken(const FlightRoom& room, const std::filesystem::path& folder);

}  // namespace vdisp
