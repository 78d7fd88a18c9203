/* client_c.h: the client library for C; see client.h for what the words promise. */
/* SPDX-License-Identifier: Apache-2.0 */
#ifndef VDISP_CLIENT_C_H
#define VDISP_CLIENT_C_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct vdisp_client vdisp_client;
typedef struct vdisp_image vdisp_image; /* read-only shared memory */

typedef enum { VDISP_FRESH, VDISP_BLIND, VDISP_STALE, VDISP_DEAD } vdisp_trust;
typedef enum { VDISP_CONNECTED, VDISP_NO_DAEMON, VDISP_NO_PERMISSION, VDISP_NO_MEMORY, VDISP_WRONG_NAME } vdisp_connection;

typedef struct {
  const vdisp_image* image; /* null: nothing has arrived yet */
  vdisp_trust trust;
  uint32_t reason; /* why blind; vdisp_reason() says it in words */
  double age_s;
} vdisp_reading;

/* What an image says of itself. Pixel kinds, reasons and flags are numbered as in image.h. */
typedef struct {
  uint16_t pixel, record, width, height;
  uint32_t stride; /* bytes from row to row */
  uint32_t valid, reason, flags;
  bool synthetic; /* from the simulator or from files: not to be driven by */
  uint64_t sequence, epoch;
  int64_t timestamp_ns, ready_ns;
  float cell_m, origin_row, origin_column; /* of the map; see GridGeometry */
  uint32_t min_count;
} vdisp_image_info;

/* Null only where there is no memory. `instance` null: the default name. One client per process. */
vdisp_client* vdisp_open(const char* instance);
void vdisp_close(vdisp_client* client);
vdisp_connection vdisp_connect(vdisp_client* client, int limit_ms);
/* What is wrong, and what would be right. */
const char* vdisp_message(const vdisp_client* client);
int vdisp_subscribe(vdisp_client* client, const char* topic);
void vdisp_unsubscribe(vdisp_client* client, int topic);
vdisp_reading vdisp_latest(vdisp_client* client, int topic);
vdisp_reading vdisp_wait(vdisp_client* client, int topic, int limit_ms);
/* Images of one frame on all topics; false at the limit. */
bool vdisp_wait_set(vdisp_client* client, const int* topics, int count, vdisp_reading* readings, int limit_ms);
void vdisp_release(vdisp_client* client, int topic);
uint64_t vdisp_epoch(const vdisp_client* client);

vdisp_image_info vdisp_describe(const vdisp_image* image);
/* Null outside the image. */
const void* vdisp_row(const vdisp_image* image, int y);
const char* vdisp_reason(uint32_t reason);

#ifdef __cplusplus
}
#endif
#endif
