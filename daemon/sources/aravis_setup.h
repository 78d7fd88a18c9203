// aravis_setup.h: [camera] and [image source] applied to a camera that is open, and what cannot be had.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <arv.h>

#include <string>

#include "config/config.h"
#include "daemon/sources/camera.h"

namespace vdisp {

/// Of one call to Aravis, with what it says.
class AravisError {
 public:
  AravisError() = default;
  ~AravisError() { g_clear_error(&error_); }
  AravisError(const AravisError&) = delete;
  AravisError& operator=(const AravisError&) = delete;
  operator GError**() {
    g_clear_error(&error_);
    return &error_;
  }
  bool happened() const { return error_ != nullptr; }
  /// Throws CameraError with the fault that fits, if there is one: "NAME: DOING: what Aravis says".
  void check(const std::string& name, const char* doing) const;

 private:
  GError* error_ = nullptr;
};

/// Pixels and region alone.
FrameFormat set_shape(ArvCamera* camera, const Config& config, const std::string& name);

/// Sets pixels, region, trigger, rate, exposure, gain and packets, in the order in which they depend on each other. Throws CameraError.
FrameFormat set_up(ArvCamera* camera, const Config& config, const std::string& name);

}  // namespace vdisp
