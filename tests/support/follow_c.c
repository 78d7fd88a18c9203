/* follow_c.c: a planner in C: reads the map and the floor of one frame, may tell the rover what to do, and counts: follow_c SECONDS
 * [orders]. A line of counts each second and at the end; 1 where frames came out of order or an order was refused. */
/* SPDX-License-Identifier: Apache-2.0 */
#define _POSIX_C_SOURCE 200809L
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "vdisp/client_c.h"
#include "vdisp/control_c.h"

static volatile sig_atomic_t stopped = 0;

static void stop(int number) {
  (void)number;
  stopped = 1;
}

static double now_s(void) {
  struct timespec time;
  clock_gettime(CLOCK_MONOTONIC, &time);
  return (double)time.tv_sec + (double)time.tv_nsec * 1e-9;
}

typedef struct {
  unsigned long long frames, missed, fallen, blind, unfresh, orders, refused;
  uint64_t sequence, epoch;
} counts;

static void print(const counts* all) {
  printf("frames %llu missed %llu fallen %llu blind %llu unfresh %llu orders %llu refused %llu sequence %llu\n", all->frames, all->missed,
         all->fallen, all->blind, all->unfresh, all->orders, all->refused, (unsigned long long)all->sequence);
  fflush(stdout);
}

static void count(counts* all, const vdisp_image_info* map, const vdisp_image_info* floor) {
  if (all->frames > 0 && map->epoch == all->epoch) {
    if (map->sequence <= all->sequence || floor->sequence != map->sequence)
      ++all->fallen;
    else
      all->missed += map->sequence - all->sequence - 1;
  }
  all->epoch = map->epoch;
  all->sequence = map->sequence;
  ++all->frames;
  if (!map->valid) ++all->blind;
}

int main(int argc, char** argv) {
  const double end = now_s() + (argc > 1 ? atof(argv[1]) : 5);
  signal(SIGTERM, stop);
  vdisp_client* client = vdisp_open(NULL);
  const int topics[2] = {vdisp_subscribe(client, "map"), vdisp_subscribe(client, "floor_model")};
  vdisp_control* control = argc > 2 ? vdisp_control_open(NULL, 1000) : NULL;
  counts all = {0};
  double told = now_s(), ordered = 0;
  while (!stopped && now_s() < end) {
    vdisp_reading set[2];
    if (vdisp_wait_set(client, topics, 2, set, 200)) {
      const vdisp_image_info map = vdisp_describe(set[0].image), floor = vdisp_describe(set[1].image);
      count(&all, &map, &floor);
    } else if (all.frames > 0) {
      ++all.unfresh;
    }
    const double now = now_s();
    if (control && now - ordered >= 0.1) {
      ordered = now;
      ++all.orders;
      if (vdisp_control_drive(control, 0, 0.5, 0) != VDISP_CONTROL_DONE) ++all.refused;
    }
    if (now - told < 1) continue;
    told = now;
    print(&all);
  }
  print(&all);
  if (control) vdisp_control_close(control);
  vdisp_close(client);
  return all.fallen == 0 && all.refused == 0 ? 0 : 1;
}
