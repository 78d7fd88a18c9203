// catalogue.h: which stages there are, and that the daemon lives.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "record.h"

namespace vdisp {

/// How CatalogueEntry::parents names an input that is of the frame before; twice gives the index back.
constexpr int16_t delayed_parent(int entry) { return static_cast<int16_t>(-2 - entry); }

/// One stage in the catalogue. Times in ns of the stage that made it; several topics of one stage share them.
struct CatalogueEntry {
  char name[48];
  ImageSpec spec;
  int16_t parents[4];  ///< indices into the catalogue, -1: none, below: delayed_parent() of an index
  uint32_t stage;      ///< which stage of the tree made it: entries of one stage have the same number
  uint32_t watched;    ///< 1: a reader is attached
  uint64_t runs, invalid, drops;
  int64_t last_ns, mean_ns, max_ns;
};

/// Published once a second as topic `catalogue`.
struct Catalogue {
  static constexpr RecordType type = RecordType::catalogue;
  static constexpr uint16_t version = 1;
  static constexpr uint32_t capacity = 64;
  RecordHeader header;
  uint64_t steps, blind_steps;
  int64_t period_ns;     ///< median time from step to step of the last 32
  int64_t step_mean_ns;  ///< mean time inside a step
  uint32_t count;
  uint32_t unused;
  CatalogueEntry entries[capacity];
};

/// Published several times a second as topic `heartbeat`, also while the daemon waits for a frame.
struct Heartbeat {
  static constexpr RecordType type = RecordType::heartbeat;
  static constexpr uint16_t version = 1;
  RecordHeader header;
  uint64_t steps;
  int64_t now_ns;     ///< CLOCK_MONOTONIC
  int64_t period_ns;  ///< median time from step to step of the last 32, 0 before the third
};

static_assert(sizeof(CatalogueEntry) == 120 && sizeof(Heartbeat) == 32);

}  // namespace vdisp
