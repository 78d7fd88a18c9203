// driver_parts.h: what the driver keeps of each topic, stage and delayed input; for driver.cpp and driver_report.cpp alone.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "daemon/core/delayed_image.h"
#include "daemon/core/driver.h"

namespace vdisp {

struct Driver::Slot {
  std::unique_ptr<Outlet> outlet;
  Image* image = nullptr;  // loaned in this step, not yet published
  int publish_after = -1;  // the last stage of this step that reads it
};

struct Driver::Stage {
  std::unique_ptr<ImageProcessor> processor;
  std::vector<Handle> inputs;
  std::vector<int> outputs;  // topics
  Need need;
  bool runs = false;  // in this step
  StageTiming timing;
  std::vector<const Image*> in;
  std::vector<Image*> out;
  /// No input of this frame: a source, or what comes in from outside.
  bool begins() const { return inputs.empty() || inputs[0].last >= 0; }
};

/// What last() was asked for.
struct Driver::Delayed {
  std::string name;
  ImageSpec spec;
  int topic = -1;                       // known from connect() on, where a stage reads it
  std::unique_ptr<DelayedImage> image;  // the same
};

}  // namespace vdisp
