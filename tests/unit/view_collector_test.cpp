// view_collector_test.cpp: which views of a board are taken: at rest, in both cameras, unlike the others; and what is still missing.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/tools/calibrate/view_collector.h"

#include <gtest/gtest.h>

namespace vdisp::calibrate {
namespace {

struct Collecting : ::testing::Test {
  static BoardOptions options() {
    BoardOptions board;
    board.size = "9x6", board.square_m = 0.03;
    return board;
  }
  Board board{options()};
  ViewCollector collector{board, {640, 480}, 8};

  /// A board of `side` px from corner to corner around (x, y); its left side longer by `across`, its top by `down`.
  BoardView view(double x, double y, double side = 20, double across = 0, double down = 0) const {
    BoardView v;
    for (int id = 0; id < board.corners(); ++id) {
      const double u = id % 9 - 4, w = id / 9 - 2.5;
      v.ids.push_back(id);
      v.corners.emplace_back(static_cast<float>(x + side * u * (1 - down * w / 5)),
                             static_cast<float>(y + side * w * (1 - across * u / 8)));
    }
    return v;
  }
  Look twice(const BoardView& v) {
    collector.consider(v, v);
    return collector.consider(v, v);
  }
};

TEST_F(Collecting, a_board_has_to_rest_for_a_frame) {
  EXPECT_EQ(collector.consider(view(320, 240), view(300, 240)), Look::moving);
  EXPECT_EQ(collector.consider(view(330, 240), view(310, 240)), Look::moving);
  EXPECT_EQ(collector.consider(view(330, 240), view(314, 240)), Look::moving);
  EXPECT_EQ(collector.consider(view(330, 240), view(314, 240)), Look::taken);
}

TEST_F(Collecting, both_cameras_have_to_see_it) {
  EXPECT_EQ(collector.consider(view(320, 240), {}), Look::no_board);
  EXPECT_EQ(collector.consider({}, {}), Look::no_board);
}

TEST_F(Collecting, the_same_view_is_taken_once_and_another_place_size_or_tilt_is_new) {
  EXPECT_EQ(twice(view(320, 240)), Look::taken);
  EXPECT_EQ(twice(view(323, 241)), Look::known);
  EXPECT_EQ(twice(view(450, 240)), Look::taken);
  EXPECT_EQ(twice(view(320, 240, 35)), Look::taken);
  EXPECT_EQ(twice(view(320, 240, 20, 0.2)), Look::taken);
  EXPECT_EQ(twice(view(320, 240, 20, 0, -0.2)), Look::taken);
  EXPECT_EQ(collector.taken(), 5u);
}

TEST_F(Collecting, a_view_taken_back_is_taken_again_only_when_asked_for) {
  EXPECT_EQ(twice(view(320, 240)), Look::taken);
  collector.undo();
  EXPECT_EQ(collector.taken(), 0u);
  EXPECT_EQ(collector.cells(), (std::array<int, 9>{}));
  EXPECT_EQ(twice(view(320, 240)), Look::known);
  EXPECT_EQ(collector.consider(view(100, 240), view(90, 240), true), Look::taken);
  EXPECT_EQ(collector.consider(view(320, 240), {}, true), Look::no_board);
  collector.undo();
  collector.undo();
  EXPECT_EQ(collector.taken(), 0u);
}

TEST_F(Collecting, it_says_what_is_missing_until_nothing_is) {
  twice(view(320, 240));
  for (const char* words : {"upper left", "lower right", "its left side nearer", "its bottom nearer"})
    EXPECT_NE(collector.missing().find(words), std::string::npos) << collector.missing();
  for (double x : {110.0, 530.0})
    for (double y : {80.0, 240.0, 400.0}) twice(view(x, y));
  twice(view(320, 80));
  twice(view(320, 400));
  for (double tilt : {-0.3, 0.3}) twice(view(320, 240, 20, tilt)), twice(view(320, 240, 20, 0, tilt));
  EXPECT_EQ(collector.missing(), "");
  EXPECT_TRUE(collector.complete());
}

}  // namespace
}  // namespace vdisp::calibrate
