// control_c.cpp: the control socket for C, in terms of the one for C++.
// SPDX-License-Identifier: Apache-2.0
#include "ipc/include/vdisp/control_c.h"

#include <algorithm>
#include <cstdio>
#include <new>

#include "ipc/include/vdisp/control.h"

struct vdisp_control {
  vdisp::Control control;
};

namespace {
vdisp_control_result result_of(vdisp::Control::Result result) { return static_cast<vdisp_control_result>(result); }
static_assert(static_cast<int>(vdisp::Control::Result::wrong_version) == VDISP_CONTROL_WRONG_VERSION);
}  // namespace

vdisp_control* vdisp_control_open(const char* path, int limit_ms) {
  try {
    return new vdisp_control{vdisp::Control(path ? path : "", std::chrono::milliseconds(std::max(limit_ms, 1)))};
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}

void vdisp_control_close(vdisp_control* control) { delete control; }
const char* vdisp_control_message(const vdisp_control* control) { return control->control.message().c_str(); }

vdisp_control_result vdisp_control_odometry(vdisp_control* control, int64_t timestamp_ns, double x, double y, double yaw, double speed,
                                            double turn_rate) {
  vdisp::OdometrySample sample;
  sample.timestamp_ns = timestamp_ns;
  sample.x = x;
  sample.y = y;
  sample.yaw = yaw;
  sample.speed = speed;
  sample.turn_rate = turn_rate;
  return result_of(control->control.odometry(sample));
}

vdisp_control_result vdisp_control_imu(vdisp_control* control, int64_t timestamp_ns, const double acceleration[3], const double rate[3]) {
  vdisp::ImuSample sample;
  sample.timestamp_ns = timestamp_ns;
  std::copy_n(acceleration, 3, sample.acceleration);
  if (rate) std::copy_n(rate, 3, sample.rate);
  return result_of(control->control.imu(sample));
}

vdisp_control_result vdisp_control_drive(vdisp_control* control, int64_t timestamp_ns, double speed, double turn_rate) {
  return result_of(control->control.drive(speed, turn_rate, timestamp_ns));
}
vdisp_control_result vdisp_control_event(vdisp_control* control, int64_t timestamp_ns, const char* label) {
  return result_of(control->control.event(label, timestamp_ns));
}
vdisp_control_result vdisp_control_set(vdisp_control* control, const char* key, const char* value) {
  return result_of(control->control.set(key, value));
}

vdisp_control_result vdisp_control_get(vdisp_control* control, const char* key, char* value, int size) {
  vdisp::ParameterInfo info;
  const auto result = control->control.get(key, info);
  if (size > 0) std::snprintf(value, static_cast<size_t>(size), "%s", info.value.c_str());
  return result_of(result);
}

vdisp_control_result vdisp_control_undo(vdisp_control* control) { return result_of(control->control.undo()); }
vdisp_control_result vdisp_control_save(vdisp_control* control) { return result_of(control->control.save()); }
