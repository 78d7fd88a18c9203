// format.h: printf into a string, also of numbers that may not be known.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <string>

namespace vdisp {

/// At most 255 letters.
[[gnu::format(printf, 1, 2)]] inline std::string format(const char* pattern, ...) {
  char text[256];
  va_list arguments;
  va_start(arguments, pattern);
  std::vsnprintf(text, sizeof text, pattern, arguments);
  va_end(arguments);
  return text;
}

/// A dash for what is not finite.
inline std::string or_dash(const char* pattern, double value, double factor = 1) {
  char text[64];
  std::snprintf(text, sizeof text, pattern, value * factor);
  return std::isfinite(value) ? text : "-";
}

}  // namespace vdisp
