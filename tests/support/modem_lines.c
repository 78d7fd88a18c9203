// modem_lines.c: preloaded, gives pseudo-terminals the modem lines of a real port, all low: libserialport opens nothing without.
// SPDX-License-Identifier: Apache-2.0
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <stdarg.h>
#include <sys/ioctl.h>

int ioctl(int fd, unsigned long request, ...) {
  static int (*real)(int, unsigned long, void*);
  if (!real) *(void**)&real = dlsym(RTLD_NEXT, "ioctl");
  va_list arguments;
  va_start(arguments, request);
  void* argument = va_arg(arguments, void*);
  va_end(arguments);
  const int result = real(fd, request, argument);
  const int lines = request == TIOCMGET || request == TIOCMSET || request == TIOCMBIS || request == TIOCMBIC;
  if (result == 0 || errno != ENOTTY || !lines) return result;
  if (request == TIOCMGET) *(int*)argument = 0;
  return 0;
}
