// contact_sheet.h: many stages on one page, each with its name.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "probe/paint.h"

namespace vdisp {

struct SheetEntry {
  std::string topic;
  const Image* image;
};

Picture contact_sheet(const std::vector<SheetEntry>& entries, int picture_rows);

}  // namespace vdisp
