// count_allocations.h: counts what a thread takes from the heap; count_allocations.cpp replaces malloc in the program it is linked to.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace vdisp {
uint64_t allocations_of_this_thread();
}
