/* control_c.c: the control socket's C header, compiled as C and used: control_c SOCKET. Ends with the number of the first step that failed.
 */
/* SPDX-License-Identifier: Apache-2.0 */
#include "vdisp/control_c.h"

#include <stdio.h>
#include <string.h>

int main(int argc, char** argv) {
  vdisp_control* control = vdisp_control_open(argc > 1 ? argv[1] : NULL, 1000);
  const double up[3] = {0, 0, 9.81};
  char value[16];
  if (vdisp_control_odometry(control, 0, 1.5, 0, 0, 0.5, 0) != VDISP_CONTROL_DONE) {
    printf("%s\n", vdisp_control_message(control));
    vdisp_control_close(control);
    return 1;
  }
  if (vdisp_control_imu(control, 0, up, NULL) != VDISP_CONTROL_DONE) return 2;
  if (vdisp_control_drive(control, 0, 0.5, 0.1) != VDISP_CONTROL_DONE) return 3;
  if (vdisp_control_event(control, 0, "collision") != VDISP_CONTROL_DONE) return 4;
  if (vdisp_control_event(control, 0, "") != VDISP_CONTROL_REFUSED) return 5;
  if (vdisp_control_set(control, "thresh", "17") != VDISP_CONTROL_DONE) return 6;
  if (vdisp_control_get(control, "thresh", value, sizeof value) != VDISP_CONTROL_DONE || strcmp(value, "17") != 0) return 7;
  if (vdisp_control_set(control, "thresh", "99") != VDISP_CONTROL_REFUSED || !strstr(vdisp_control_message(control), "from 0 to 40"))
    return 8;
  if (vdisp_control_set(control, "nosuch", "1") != VDISP_CONTROL_UNKNOWN) return 9;
  if (vdisp_control_set(control, "ndisp", "64") != VDISP_CONTROL_NEEDS_RESTART) return 10;
  if (vdisp_control_undo(control) != VDISP_CONTROL_DONE || vdisp_control_undo(control) != VDISP_CONTROL_REFUSED) return 11;
  if (vdisp_control_save(control) != VDISP_CONTROL_FAILED) return 12; /* a daemon without a file */
  vdisp_control_close(control);
  return 0;
}
