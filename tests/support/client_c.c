/* client_c.c: the C header, compiled as C and used. */
/* SPDX-License-Identifier: Apache-2.0 */
#include "vdisp/client_c.h"

#include <stdio.h>

int main(int argc, char** argv) {
  (void)argv;
  vdisp_client* client = vdisp_open(NULL);
  const int map = vdisp_subscribe(client, "map");
  const vdisp_connection connection = vdisp_connect(client, 500);
  if (argc == 1) {
    const vdisp_reading nothing = vdisp_latest(client, map);
    printf("%s\n", vdisp_message(client));
    vdisp_close(client);
    return connection == VDISP_NO_DAEMON && nothing.trust == VDISP_DEAD && nothing.image == NULL ? 0 : 1;
  }
  if (connection != VDISP_CONNECTED) return 2;
  const int topics[2] = {map, vdisp_subscribe(client, "left")};
  vdisp_reading set[2];
  if (!vdisp_wait_set(client, topics, 2, set, 1000)) return 3;
  const vdisp_image_info info = vdisp_describe(set[0].image);
  if (info.width != 51 || info.height != 50 || !info.valid || !info.synthetic || info.epoch != vdisp_epoch(client)) return 4;
  if (info.sequence != vdisp_describe(set[1].image).sequence) return 5;
  const int16_t* row = vdisp_row(set[0].image, (int)(info.sequence % 50));
  if (!row || row[30] != 100 || vdisp_row(set[0].image, 50) != NULL) return 6;
  if (vdisp_wait(client, map, 500).trust != VDISP_FRESH) return 7;
  vdisp_release(client, map);
  vdisp_unsubscribe(client, map);
  vdisp_close(client);
  return 0;
}
