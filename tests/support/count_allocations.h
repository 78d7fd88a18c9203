// count_allocations.h: counts what the calling thread takes from the heap; replaces operator new and malloc in the program that includes it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace vdisp {
uint64_t allocations_of_this_thread();
}
