// received.h: what a client believes of what it received: an image's header, the entries of a catalogue, whether the daemon lives.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "ipc/include/vdisp/client.h"

namespace vdisp {

/// Widest and highest picture: readers may multiply and add such numbers without a second thought.
inline constexpr uint16_t longest_side = 16384;

/// The image that lies in these bytes, or null: magic, version, kind of pixels, a size that is one and fits, a reason that is known.
/// Nothing beyond `bytes` is read, and nobody who keeps to the header reads beyond it.
const Image* image_in(const void* memory, uint64_t bytes) noexcept;

/// The entries of a catalogue: names end with a zero, inputs are entries.
std::vector<CatalogueEntry> entries_of(const Catalogue& catalogue);

/// What the last heartbeat said.
struct Beat {
  uint64_t epoch = 0;                   ///< 0: there is no connection
  int64_t ready_ns = 0, period_ns = 0;  ///< of its image; from step to step
  /// How long is not too long: three periods, or longer where those are short.
  int64_t patience(int64_t least) const;
};

/// How far an image can be trusted `now`. What bears a time that is yet to come was not made by this clock, and is as little trusted as
/// what is too old. `image` may be null.
Reading judged(const Image* image, const Beat& beat, int64_t now_ns) noexcept;

}  // namespace vdisp
