// way_map.h: a map of bare ground ahead of the rover, into which a test puts what stands there.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cmath>

#include "daemon/stages/map_driver.h"
#include "tests/support/picture.h"

namespace vdisp {

/// A map of 5 x 5.1 m ahead of the rover: from 0.4 m on in view, and free.
struct MapDriverTest : testing::Test {
  static constexpr int rows = 50, columns = 51;
  Config config;
  Picture grid{Pixel::int8, columns, rows}, reason{Pixel::gray8, columns, rows};

  MapDriverTest() {
    config.decide.width = 0.4;
    config.decide.margin = 0.1;
    config.decide.near = 1;
    config.decide.far = 3;
    for (Picture* picture : {&grid, &reason}) picture->image().grid = {0.1f, rows, columns / 2.f, -1, 1, 3, 0, 0, 0, 0};
    reason.fill<uint8_t>([](int row, int) { return static_cast<uint8_t>(row < rows - 4 ? CellReason::floor : CellReason::out_of_view); });
    grid.fill<int8_t>([](int row, int) { return static_cast<int8_t>(row < rows - 4 ? 0 : -1); });
  }
  /// The cell whose middle is `ahead` and `left` in m.
  void put(double ahead, double left, int value, CellReason why) {
    const int row = rows - 1 - static_cast<int>(ahead / 0.1), column = static_cast<int>(std::floor(-left / 0.1 + columns / 2.0));
    grid.at<int8_t>(row, column) = static_cast<int8_t>(value);
    reason.at<uint8_t>(row, column) = static_cast<uint8_t>(why);
  }
  void obstacle(double ahead, double left) { put(ahead, left, 90, CellReason::obstacle); }
  MapWay look() {
    MapDriver driver(config);
    driver.prepare(grid.spec());
    return driver.look(grid.image(), &reason.image());
  }
};

}  // namespace vdisp
