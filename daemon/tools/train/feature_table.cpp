// feature_table.cpp: pieces of recordings, shared by threads, each with a front end of its own.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/tools/train/feature_table.h"

#include <algorithm>
#include <optional>

#include "daemon/tools/train/front_end.h"
#include "daemon/tools/train/parallel.h"
#include "daemon/tools/train/progress.h"

namespace vdisp::train {
namespace {

constexpr uint32_t piece = 128;  // samples: building a front end costs as much as a few

struct Piece {
  uint32_t first, last;  // samples of one recording
};

std::vector<Piece> pieces_of(const Drives& drives) {
  std::vector<Piece> pieces;
  for (uint32_t i = 0; i < drives.samples.size(); ++i) {
    const bool fresh = pieces.empty() || i - pieces.back().first >= piece || drives.samples[i].drive != drives.samples[i - 1].drive;
    if (fresh) pieces.push_back({i, i});
    pieces.back().last = i + 1;
  }
  return pieces;
}

/// A thread's front end, and of which recording it is.
struct Seat {
  std::optional<uint32_t> drive;
  std::unique_ptr<FrontEnd> front_end;
};

}  // namespace

FeatureTable::FeatureTable(const Drives& drives, const snow::Settings& settings, std::span<const snow::Encoding> encodings, int threads) {
  for (const snow::Encoding encoding : encodings) {
    const ImageSpec spec = snow::feature_spec(encoding);
    const size_t bytes = static_cast<size_t>(spec.width) * spec.height;
    columns_[encoding] = {bytes, std::vector<uint8_t>(bytes * drives.samples.size())};
  }
  blind_.resize(drives.samples.size());
  const auto pieces = pieces_of(drives);
  Machine machine;  // of one thread: the pairs are what is shared
  std::vector<Seat> seats(static_cast<size_t>(threads));
  Progress progress("features", drives.samples.size());
  in_parallel(threads, pieces.size(), [&](size_t task, int number) {
    Seat& seat = seats[static_cast<size_t>(number)];
    const uint32_t drive = drives.samples[pieces[task].first].drive;
    if (seat.drive != drive) {
      seat.front_end = std::make_unique<FrontEnd>(drives.recordings[drive], settings, machine);
      seat.drive = drive;
    }
    for (uint32_t sample = pieces[task].first; sample < pieces[task].last; ++sample) {
      blind_[sample] = seat.front_end->run(drives.samples[sample].pair) != Reason::none;
      for (auto& [encoding, column] : columns_)
        if (!blind_[sample]) seat.front_end->features(encoding, {column.pixels.data() + column.bytes * sample, column.bytes});
      progress.add(1);
    }
  });
}

std::vector<uint32_t> FeatureTable::numbers(const Drives& drives, bool held_apart) const {
  std::vector<uint32_t> seen = drives.numbers(held_apart);
  std::erase_if(seen, [this](uint32_t sample) { return blind(sample); });
  return seen;
}

Classes FeatureTable::classes(const Drives& drives, bool held_apart) const {
  Classes found;
  for (const uint32_t sample : numbers(drives, held_apart)) found.add(drives.samples[sample].label);
  return found;
}

size_t FeatureTable::blind_count() const { return static_cast<size_t>(std::count(blind_.begin(), blind_.end(), 1)); }

std::span<const uint32_t> FeatureTable::ids(snow::Encoding encoding, uint32_t sample, std::span<uint32_t> ids) const {
  const Columns& column = columns_.at(encoding);
  const auto some = ids.first(snow::active_features(encoding));
  snow::feature_ids(encoding, std::span<const uint8_t>(column.pixels.data() + column.bytes * sample, column.bytes), some);
  return some;
}

}  // namespace vdisp::train
