// received.cpp: every number in shared memory is another process' word.
// SPDX-License-Identifier: Apache-2.0
#include "ipc/received.h"

#include <algorithm>

namespace vdisp {
namespace {

constexpr int64_t least_patience_ns = 300'000'000, daemon_patience_ns = 1'000'000'000;

bool known(Pixel pixel) { return pixel > Pixel::none && pixel <= Pixel::record; }

/// Readers look at row 0 of what has one row, and divide by width and height.
bool possible(const ImageSpec& spec) {
  if (!known(spec.pixel) || spec.width == 0 || spec.height == 0) return false;
  return spec.pixel == Pixel::record ? spec.height == 1 : spec.width <= longest_side && spec.height <= longest_side;
}

bool within(int64_t at_ns, int64_t now_ns, int64_t patience_ns) { return at_ns >= now_ns - patience_ns && at_ns <= now_ns + patience_ns; }

}  // namespace

const Image* image_in(const void* memory, uint64_t bytes) noexcept {
  if (reinterpret_cast<uintptr_t>(memory) % alignof(Image) != 0 || bytes < sizeof(Image)) return nullptr;
  const auto* image = static_cast<const Image*>(memory);
  if (image->magic != Image::magic_value || image->version != Image::version_value || !possible(image->spec)) return nullptr;
  if (sizeof(Image) + static_cast<uint64_t>(image->spec.stride()) * image->spec.height > bytes) return nullptr;
  return static_cast<uint32_t>(image->reason) < static_cast<uint32_t>(Reason::count) ? image : nullptr;
}

std::vector<CatalogueEntry> entries_of(const Catalogue& catalogue) {
  const uint32_t count = std::min(catalogue.count, Catalogue::capacity);
  std::vector<CatalogueEntry> entries(catalogue.entries, catalogue.entries + count);
  for (CatalogueEntry& entry : entries) {
    entry.name[sizeof entry.name - 1] = 0;
    for (int16_t& parent : entry.parents) {
      const int index = parent < -1 ? delayed_parent(parent) : parent;
      if (index >= static_cast<int>(count)) parent = -1;
    }
  }
  return entries;
}

int64_t Beat::patience(int64_t least) const { return std::max(3 * period_ns, least); }

Reading judged(const Image* image, const Beat& beat, int64_t now_ns) noexcept {
  Reading reading;
  reading.image = image;
  if (image) {
    // Their difference may be more than 64 bits hold.
    reading.age_s = (static_cast<double>(now_ns) - static_cast<double>(image->ready_ns)) * 1e-9;
    reading.reason = image->reason;
  }
  if (beat.epoch == 0 || !within(beat.ready_ns, now_ns, beat.patience(daemon_patience_ns)) || (image && image->epoch != beat.epoch))
    reading.trust = Trust::dead;
  else if (!image || !within(image->ready_ns, now_ns, beat.patience(least_patience_ns)))
    reading.trust = Trust::stale;
  else
    reading.trust = image->valid() ? Trust::fresh : Trust::blind;
  return reading;
}

}  // namespace vdisp
