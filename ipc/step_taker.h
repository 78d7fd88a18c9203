// step_taker.h: copies out of the images of a step what a recording keeps of it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>

#include "ipc/recorded_step.h"

namespace vdisp {

/// A step in memory: its views lie one behind the other, rows `views.stride` apart.
struct TakenStep {
  explicit TakenStep(const ImageSpec& camera);

  RecordedStep step;
  RecordedViews views;

 private:
  friend class StepTaker;
  std::unique_ptr<uint8_t[]> pixels_;  // not touched before it is needed: a ring that is not full costs no memory
};

/// Looks at the images of a step: in the daemon just before they are published, elsewhere as they come. No allocation, no wait.
/// The label is the simulator's (truth/steering), else what the operator's order turns to (in/drive, younger than 300 ms). Speed and turn
/// rate are those of the published `drive`, else of the operator's order.
class StepTaker {
 public:
  explicit StepTaker(const ImageSpec& camera) : camera_(camera) {}

  /// From here on images of the next step go there.
  void begin(TakenStep& into) noexcept;
  void see(std::string_view topic, const Image& image) noexcept;
  /// The step is over: decides on label and order. False: no image of it came.
  bool finish() noexcept;

 private:
  ImageSpec camera_;
  TakenStep* taken_ = nullptr;
  bool seen_ = false, told_label_ = false, told_drive_ = false;
};

}  // namespace vdisp
