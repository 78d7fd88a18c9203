// own_allocations.h: counts what this thread takes from the heap, OpenCV's share apart; own_allocations.cpp replaces malloc.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace vdisp {

struct Allocations {
  uint64_t own = 0;     ///< from our code
  uint64_t opencv = 0;  ///< from inside OpenCV: the matchers take work space in every call
  std::string first;    ///< who made the first of our own, innermost first
};

/// Counts between construction and end(), in this thread.
class CountAllocations {
 public:
  CountAllocations();
  Allocations end();
};

}  // namespace vdisp
