// stepped_clock.c: preloaded, gives one program a wall clock that a test steps: VDISP_CLOCK names a file that says how far ahead it is.
// SPDX-License-Identifier: Apache-2.0
// Waits for a wall time end when this clock gets there, as the kernel's do. Monotonic time is left alone.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <semaphore.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/time.h>
#include <time.h>

#define SECOND 1000000000LL
#define SLICE 20000000LL  // of a wait: a step is seen so soon

static const volatile int64_t* ahead;
static int (*real_gettime)(clockid_t, struct timespec*);

__attribute__((constructor)) static void open_file(void) {
  *(void**)&real_gettime = dlsym(RTLD_NEXT, "clock_gettime");
  const char* name = getenv("VDISP_CLOCK");
  const int fd = name ? open(name, O_RDONLY | O_CLOEXEC) : -1;
  void* memory = fd < 0 ? MAP_FAILED : mmap(NULL, sizeof(int64_t), PROT_READ, MAP_SHARED, fd, 0);
  if (memory != MAP_FAILED) ahead = memory;
}

static struct timespec moved(struct timespec time, int64_t by) {
  const int64_t ns = time.tv_sec * SECOND + time.tv_nsec + by;
  return (struct timespec){ns / SECOND, ns % SECOND};
}

static int64_t until(const struct timespec* then) {
  struct timespec now;
  clock_gettime(CLOCK_REALTIME, &now);
  return (then->tv_sec - now.tv_sec) * SECOND + then->tv_nsec - now.tv_nsec;
}

// The end of the next slice of a wait, by the real clock; 0: the wait is over.
static int next_slice(const struct timespec* then, struct timespec* slice) {
  const int64_t left = until(then);
  real_gettime(CLOCK_REALTIME, slice);
  *slice = moved(*slice, left < SLICE ? (left > 0 ? left : 0) : SLICE);
  return left > 0;
}

int clock_gettime(clockid_t clock, struct timespec* time) {
  if (!real_gettime) *(void**)&real_gettime = dlsym(RTLD_NEXT, "clock_gettime");
  const int result = real_gettime(clock, time);
  if (result == 0 && ahead && (clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_COARSE)) *time = moved(*time, *ahead);
  return result;
}

int gettimeofday(struct timeval* restrict time, void* restrict zone) {
  struct timespec now;
  (void)zone;
  clock_gettime(CLOCK_REALTIME, &now);
  *time = (struct timeval){now.tv_sec, now.tv_nsec / 1000};
  return 0;
}

time_t time(time_t* out) {
  struct timespec now;
  clock_gettime(CLOCK_REALTIME, &now);
  if (out) *out = now.tv_sec;
  return now.tv_sec;
}

int sem_timedwait(sem_t* restrict semaphore, const struct timespec* restrict then) {
  static int (*real)(sem_t*, const struct timespec*);
  if (!real) *(void**)&real = dlsym(RTLD_NEXT, "sem_timedwait");
  for (struct timespec slice;;) {
    const int more = next_slice(then, &slice);
    if (real(semaphore, &slice) == 0) return 0;
    if (errno != ETIMEDOUT || !more) return -1;
  }
}
