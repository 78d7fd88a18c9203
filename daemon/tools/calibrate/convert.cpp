// convert.cpp: the word `convert`: a calibration in another format, with nothing lost.
// SPDX-License-Identifier: Apache-2.0
#include <sysexits.h>

#include <cstdio>
#include <iostream>

#include "daemon/tools/calibrate/files_out.h"
#include "daemon/tools/calibrate/words.h"

namespace vdisp::calibrate {
namespace {

void set_size(Calibration& calibration, const std::string& text) {
  int width = 0, height = 0, used = 0;
  if (std::sscanf(text.c_str(), "%5dx%5d%n", &width, &height, &used) != 2 || static_cast<size_t>(used) != text.size() || width < 16 ||
      height < 16 || width > 16384 || height > 16384)
    throw ToolError(EX_USAGE, "--size " + text + ": needed is WIDTHxHEIGHT, each from 16 to 16384, as 640x480");
  if (calibration.width && (calibration.width != width || calibration.height != height))
    throw ToolError(EX_USAGE, "--size " + text + ", but the file is of images of " + std::to_string(calibration.width) + "x" +
                                  std::to_string(calibration.height) + "; needed is no --size");
  calibration.width = width;
  calibration.height = height;
}

}  // namespace

int convert(const Options& options) {
  const CalibrationFormat format = format_for(options.output, options.format);
  Calibration calibration = read_input(options.input, options.reading);
  if (!options.size.empty()) set_size(calibration, options.size);
  write_calibration(calibration, format, options.output);
  std::cout << options.output << ": written from " << calibration.format << ", "
            << (calibration.raw ? "two cameras with their rectification" : "of images that are rectified") << '\n';
  return EX_OK;
}

}  // namespace vdisp::calibrate
