// map_changes_test.cpp: a reader that only follows the list has the same grid, and is told when the list is not enough.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/map_changes.h"

#include <gtest/gtest.h>

#include <random>

#include "daemon/core/driver.h"
#include "tests/support/count_allocations.h"
#include "tests/support/picture.h"

namespace vdisp {
namespace {

constexpr int rows = 50, columns = 51;

struct MapChangesTest : testing::Test {
  MapComparison stage;
  Picture grid{Pixel::int8, columns, rows};
  Picture out{record_spec<MapChanges>()};

  MapChangesTest() {
    EXPECT_EQ(stage.check(std::vector{grid.spec()}), std::vector{record_spec<MapChanges>()});
    grid.image().epoch = 5;
    grid.image().grid = {0.1f, rows, columns / 2.f, -0.5f, 0.5f, 3, 0, 0.1f, 0, 0};
    grid.fill<int8_t>([](int, int) { return int8_t{-1}; });
  }
  /// The next frame.
  const MapChanges& step() {
    ++grid.image().sequence;
    const Image* const in[] = {&grid.image()};
    Image* const images[] = {&out.image()};
    EXPECT_EQ(stage.process(in, images), Outcome::valid);
    return *record_of<MapChanges>(out.image());
  }
};

TEST_F(MapChangesTest, the_first_grid_has_to_be_read_whole) {
  const MapChanges& changes = step();
  EXPECT_EQ(changes.whole, WholeGrid::first);
  EXPECT_EQ(changes.generation, 1u);
  EXPECT_EQ(changes.previous, 0u);
  EXPECT_EQ(changes.count, 0u);
  EXPECT_EQ(changes.changed, 2550u) << "also where all is unknown";
}

TEST_F(MapChangesTest, lists_what_changed_by_rows_and_columns_and_counts_on) {
  step();
  grid.at<int8_t>(49, 0) = 0;
  grid.at<int8_t>(3, 50) = 100;
  const MapChanges& changes = step();
  EXPECT_EQ(changes.whole, WholeGrid::no);
  EXPECT_EQ(changes.previous, 1u);
  EXPECT_EQ(changes.generation, 2u);
  ASSERT_EQ(changes.count, 2u);
  EXPECT_EQ(changes.changed, 2u);
  EXPECT_EQ(changes.cells[0].row, 3);
  EXPECT_EQ(changes.cells[0].column, 50);
  EXPECT_EQ(changes.cells[0].value, 100);
  EXPECT_EQ(changes.cells[1].row, 49);
  EXPECT_EQ(changes.cells[1].column, 0);
  EXPECT_EQ(changes.cells[1].value, 0);
}

TEST_F(MapChangesTest, the_rover_moves_no_cells_of_a_grid_in_the_odometry_frame) {
  grid.image().grid.frame = grid_of_odometry;
  step();
  grid.image().grid.pose_x = 0.5f;
  grid.image().grid.pose_yaw = -0.1f;
  EXPECT_EQ(step().whole, WholeGrid::no);
  grid.image().grid.origin_row += 9;
  EXPECT_EQ(step().whole, WholeGrid::moved);
  grid.image().grid.frame = grid_of_camera;
  EXPECT_EQ(step().whole, WholeGrid::moved);
}

TEST_F(MapChangesTest, a_frame_without_a_change_has_the_generation_of_the_last) {
  step();
  for (int i = 0; i < 3; ++i) {
    const MapChanges& changes = step();
    EXPECT_EQ(changes.generation, 1u);
    EXPECT_EQ(changes.previous, 1u);
    EXPECT_EQ(changes.count, 0u);
    EXPECT_EQ(changes.whole, WholeGrid::no);
  }
}

TEST_F(MapChangesTest, as_many_changes_as_fit_are_listed_and_one_more_is_an_overflow) {
  step();
  int left = MapChanges::capacity;
  grid.fill<int8_t>([&](int, int) { return left-- > 0 ? int8_t{50} : int8_t{-1}; });
  const MapChanges& full = step();
  EXPECT_EQ(full.count, MapChanges::capacity);
  EXPECT_EQ(full.whole, WholeGrid::no);
  EXPECT_EQ(full.cells[MapChanges::capacity - 1].value, 50);
  left = MapChanges::capacity + 1;
  grid.fill<int8_t>([&](int, int) { return left-- > 0 ? int8_t{60} : int8_t{-1}; });
  const MapChanges& over = step();
  EXPECT_EQ(over.whole, WholeGrid::overflow);
  EXPECT_EQ(over.count, 0u);
  EXPECT_EQ(over.changed, MapChanges::capacity + 1);
  EXPECT_EQ(over.generation, 3u);
  EXPECT_EQ(step().generation, 3u) << "the copy is complete after an overflow";
}

TEST_F(MapChangesTest, a_grid_after_blindness_has_to_be_read_whole_even_where_it_is_the_same) {
  step();
  ++grid.image().sequence;  // a step of which there was no grid
  const MapChanges& changes = step();
  EXPECT_EQ(changes.whole, WholeGrid::after_blind);
  EXPECT_EQ(changes.generation, 2u) << "who missed this record has to notice by the next";
  EXPECT_EQ(step().whole, WholeGrid::no);
}

TEST_F(MapChangesTest, a_grid_of_other_ground_has_to_be_read_whole) {
  step();
  grid.image().grid.view_left = -0.6f;  // the view is no place
  EXPECT_EQ(step().whole, WholeGrid::no);
  grid.image().grid.origin_row = 60;
  EXPECT_EQ(step().whole, WholeGrid::moved);
  grid.image().grid.pose_yaw = 0.1f;
  EXPECT_EQ(step().whole, WholeGrid::moved);
  EXPECT_EQ(step().generation, 3u);
}

TEST_F(MapChangesTest, generations_begin_anew_with_an_epoch) {
  for (int i = 0; i < 4; ++i) {
    grid.at<int8_t>(i, i) = 0;
    step();
  }
  grid.image().epoch = 6;
  const MapChanges& changes = step();
  EXPECT_EQ(changes.whole, WholeGrid::first);
  EXPECT_EQ(changes.generation, 1u);
  EXPECT_EQ(changes.previous, 0u);
}

TEST_F(MapChangesTest, generations_go_on_when_a_recording_begins_and_the_grid_is_to_be_read_whole) {
  for (int i = 0; i < 4; ++i) {
    grid.at<int8_t>(i, i) = 0;
    step();
  }
  const uint64_t before = step().generation;
  stage.begin_anew();
  const MapChanges& changes = step();
  EXPECT_EQ(changes.whole, WholeGrid::first);
  EXPECT_GT(changes.generation, before) << "who has any generation of this epoch must not take it for this one";
  EXPECT_EQ(step().whole, WholeGrid::no);
}

TEST_F(MapChangesTest, a_reader_of_lists_has_the_grid_after_500_random_frames) {
  std::mt19937 random(3);
  std::vector<int> copy(rows * columns, -2);
  uint64_t has = 0;
  int listed = 0;
  for (int frame = 0; frame < 500; ++frame) {
    for (auto i = random() % 1200; i-- > 0;)
      grid.at<int8_t>(static_cast<int>(random() % rows), static_cast<int>(random() % columns)) = static_cast<int8_t>(random() % 102) - 1;
    if (random() % 20 == 0) ++grid.image().sequence;
    const MapChanges& changes = step();
    if (changes.whole == WholeGrid::no && changes.previous == has) {
      for (uint32_t i = 0; i < changes.count; ++i) copy[changes.cells[i].row * columns + changes.cells[i].column] = changes.cells[i].value;
      ++listed;
    } else {
      for (int i = 0; i < rows * columns; ++i) copy[static_cast<size_t>(i)] = grid.at<int8_t>(i / columns, i % columns);
    }
    has = changes.generation;
    for (int i = 0; i < rows * columns; ++i)
      ASSERT_EQ(copy[static_cast<size_t>(i)], grid.at<int8_t>(i / columns, i % columns)) << frame << " cell " << i;
  }
  EXPECT_GT(listed, 300);
}

TEST_F(MapChangesTest, nothing_is_taken_from_the_heap) {
  const uint64_t before = allocations_of_this_thread();
  for (int8_t value = 0; value < 100; ++value) {
    grid.at<int8_t>(value % rows, 7) = value;
    step();
  }
  EXPECT_EQ(allocations_of_this_thread(), before);
}

TEST_F(MapChangesTest, refuses_what_is_no_occupancy) {
  EXPECT_THROW(stage.check(std::vector<ImageSpec>{{Pixel::count16, 0, columns, rows}}), FormatError);
  EXPECT_THROW(stage.check(std::vector<ImageSpec>{}), FormatError);
  EXPECT_THROW(stage.check(std::vector{grid.spec(), grid.spec()}), FormatError);
}

/// A grid that is blind in every third frame, and changes in none.
struct Blinking final : ImageSource {
  std::vector<ImageSpec> open() override { return {{Pixel::int8, 0, columns, rows}}; }
  Outcome grab(std::span<Image* const> out) noexcept override {
    for (int row = 0; row < rows; ++row) std::memset(out[0]->row<int8_t>(row), 0, columns);
    out[0]->reason = Reason::few_points;
    return out[0]->sequence % 3 == 2 ? Outcome::invalid : Outcome::valid;
  }
};

TEST(MapChangesInATree, a_blind_grid_makes_a_blind_record_and_the_next_says_after_blind) {
  Driver driver(9);
  const Handle occupancy = driver.add("occupancy", std::make_unique<Blinking>(), {}, Need::always);
  driver.add("map_changes", std::make_unique<MapComparison>(), {occupancy}, Need::always);
  std::vector<std::string> said;
  driver.set_viewer([&](const Topic& topic, const Image& image) {
    if (topic.name != "map_changes") return;
    EXPECT_EQ(image.epoch, 9u);
    const MapChanges* changes = image.valid() ? record_of<MapChanges>(image) : nullptr;
    const WholeGrid whole = changes ? changes->whole : WholeGrid::no;
    const char* word = whole == WholeGrid::first         ? " first"
                       : whole == WholeGrid::after_blind ? " after_blind"
                       : whole == WholeGrid::no          ? ""
                                                         : "?";
    said.push_back(changes ? std::to_string(changes->generation) + word : "blind");
  });
  driver.connect([](const std::string&, const ImageSpec& spec) { return std::make_unique<BufferOutlet>(spec); });
  for (int i = 0; i < 8; ++i) driver.step();
  EXPECT_EQ(said, (std::vector<std::string>{"1 first", "1", "blind", "2 after_blind", "2", "blind", "3 after_blind", "3"}));
}

}  // namespace
}  // namespace vdisp
