// files_out.h: calibrations on their way to disk: which format a name means, and all files of it or none.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "daemon/geometry/calibration_write.h"

namespace vdisp::calibrate {

/// `format`: svs, opencv, ros or empty for what the ending of `path` means. Throws ToolError (64).
CalibrationFormat format_for(const std::filesystem::path& path, const std::string& format);

/// A calibration of any known format. Throws ToolError (66) where there is no such file, CalibrationError where it is wrong.
Calibration read_input(const std::filesystem::path& path, const ReadingOptions& options);

/// Writes the file, or the folder of a pair, so that a reader finds all of it or nothing new. What was written is read back and must
/// hold the same numbers. Throws WriteError, CalibrationError; nothing is left then.
void write_calibration(const Calibration& calibration, CalibrationFormat format, const std::filesystem::path& path);

}  // namespace vdisp::calibrate
