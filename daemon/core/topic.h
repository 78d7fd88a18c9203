// topic.h: what the tree makes: its topics, and how one stage names what it takes of another.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "ipc/image.h"

namespace vdisp {

/// One topic of the tree. Where `last` is not -1 Driver::last() gave it: what the topic (known from connect() on) showed in the last frame.
struct Handle {
  int topic = -1, last = -1;
  bool even_blind = false;  ///< its reader runs also where it is blind
};
/// The same input for a reader that has an answer where it is blind (what comes in, say) and asks valid(). A first input, too: it gives
/// frame and time also where it is blind.
constexpr Handle even_blind(Handle input) {
  input.even_blind = true;
  return input;
}

/// When a stage runs.
enum class Need { on_demand, always };

struct StageTiming {
  uint64_t runs = 0, invalid = 0;
  int64_t last_ns = 0, total_ns = 0, max_ns = 0;
};

/// What a topic looks like from outside.
struct Topic {
  std::string name;
  ImageSpec spec;
  std::vector<Handle> parents;
  int stage = 0;
};

}  // namespace vdisp
