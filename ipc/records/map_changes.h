// map_changes.h: which cells of a map are other than they were.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "record.h"

namespace vdisp {

/// One cell of `occupancy`, or of `fused`, that is other than it was.
struct ChangedCell {
  uint16_t row, column;  ///< as in the image: row 0 is farthest
  int8_t value;          ///< the new one: -1 unknown, 0..100
  uint8_t unused;
};

/// Why the list of MapChanges is no list, and the whole grid has to be read.
enum class WholeGrid : uint32_t {
  no = 0,           ///< it need not: the list is complete
  first = 1,        ///< nothing to compare with: the first grid of this epoch, or since a recording began (event `recording`)
  after_blind = 2,  ///< since the last grid there were frames without one, in which all cells were unknown
  moved = 3,        ///< the grid lies elsewhere or has other cells
  overflow = 4,     ///< more cells changed than the list holds
};

/// What changed in the `occupancy` of the same frame (same sequence) since the last one, topic `map_changes`; `fused_changes` tells the
/// same of `fused`. For planners that plan again only where something changed. `generation` is one more with each frame in which anything
/// changed, starts at 1 with each epoch (Image::epoch, in the header of the image that carries the record) and never goes back within one.
/// Who has a copy of the grid at generation G of the same epoch:
///   generation == G                      has all of it, nothing changed;
///   previous == G and whole == no        writes the `count` cells of the list into the copy;
///   else                                 missed something, or there is no list: reads the whole grid.
/// A blind image of this topic has no record: all cells are unknown. The first record after it says after_blind.
struct MapChanges {
  static constexpr RecordType type = RecordType::map_changes;
  static constexpr uint16_t version = 1;
  static constexpr uint32_t capacity = 1024;
  RecordHeader header;
  uint64_t generation;
  uint64_t previous;  ///< generation of the last frame that had a grid; 0 where there is none; == generation: nothing changed
  WholeGrid whole;
  uint32_t count;    ///< cells in the list, in the order of rows and columns; 0 where the whole grid has to be read
  uint32_t changed;  ///< cells that are other than in the last grid, listed or not; all of them where nothing can be compared
  uint32_t unused;
  ChangedCell cells[capacity];
};

static_assert(sizeof(ChangedCell) == 6 && sizeof(MapChanges) == 40 + 6 * MapChanges::capacity);

}  // namespace vdisp
