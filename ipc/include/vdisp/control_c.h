/* control_c.h: the control socket for C; see control.h for what the words promise. */
/* SPDX-License-Identifier: Apache-2.0 */
#ifndef VDISP_CONTROL_C_H
#define VDISP_CONTROL_C_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct vdisp_control vdisp_control;

/* In the order of Control::Result. */
typedef enum {
  VDISP_CONTROL_DONE,
  VDISP_CONTROL_REFUSED,
  VDISP_CONTROL_UNKNOWN,
  VDISP_CONTROL_NEEDS_RESTART,
  VDISP_CONTROL_FAILED,
  VDISP_CONTROL_NO_DAEMON,
  VDISP_CONTROL_NO_PERMISSION,
  VDISP_CONTROL_BUSY,
  VDISP_CONTROL_NO_ANSWER,
  VDISP_CONTROL_WRONG_VERSION
} vdisp_control_result;

/* Null only where there is no memory. `path` null: where the daemon has it without [control] socket. */
vdisp_control* vdisp_control_open(const char* path, int limit_ms);
void vdisp_control_close(vdisp_control* control);
/* Of the last call, in one line. */
const char* vdisp_control_message(const vdisp_control* control);

/* timestamp_ns: CLOCK_MONOTONIC of the measurement, 0: now. Odometry frame (REP-103), m and rad; yaw positive to the left. What is not
 * known is NAN: speed (m/s), turn_rate (rad/s). */
vdisp_control_result vdisp_control_odometry(vdisp_control* control, int64_t timestamp_ns, double x, double y, double yaw, double speed,
                                            double turn_rate);
/* Rover frame; the acceleration points up at rest. rate null: not measured. */
vdisp_control_result vdisp_control_imu(vdisp_control* control, int64_t timestamp_ns, const double acceleration[3], const double rate[3]);
vdisp_control_result vdisp_control_drive(vdisp_control* control, int64_t timestamp_ns, double speed, double turn_rate);
vdisp_control_result vdisp_control_event(vdisp_control* control, int64_t timestamp_ns, const char* label);

vdisp_control_result vdisp_control_set(vdisp_control* control, const char* key, const char* value);
/* The value as text, cut at `size` bytes with the zero. */
vdisp_control_result vdisp_control_get(vdisp_control* control, const char* key, char* value, int size);
vdisp_control_result vdisp_control_undo(vdisp_control* control);
vdisp_control_result vdisp_control_save(vdisp_control* control);

#ifdef __cplusplus
}
#endif
#endif
