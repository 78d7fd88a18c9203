// recorder.h: `--record DIR` as the daemon's options and tree have it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "config/config.h"
#include "daemon/core/driver.h"
#include "daemon/geometry/calibration.h"
#include "daemon/record/record.h"

namespace vdisp {

/// What a recording tells of this run: its source, world and seed.
RecordingInfo recording_info(const Config& config, const Driver& driver, uint64_t epoch);
/// The files that lie beside the pairs: calibration.yml where there is one, and vdisp.cfg as it was understood.
std::vector<std::pair<std::string, std::string>> recording_texts(const Config& config, const std::optional<Calibration>& calibration);

/// Format of camera/left in this tree.
ImageSpec camera_spec(const Driver& driver);

/// Makes the simulator's labels as well, where it has some. Throws WriteError.
std::unique_ptr<Record> start_record(const std::string& folder, Driver& driver, const Config& config,
                                     const std::optional<Calibration>& calibration, uint64_t epoch);

}  // namespace vdisp
