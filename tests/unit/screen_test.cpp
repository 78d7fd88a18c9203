// screen_test.cpp: the window's picture holds at any size and state, with sliders under the mouse; the tree holds at any catalogue.
// SPDX-License-Identifier: Apache-2.0
#include "probe/view/screen.h"

#include <gtest/gtest.h>

#include <cstring>
#include <set>

#include "ipc/outlet.h"
#include "ipc/records.h"
#include "probe/tree.h"

namespace vdisp {
namespace {

CatalogueEntry entry(const char* name, ImageSpec spec, std::initializer_list<int16_t> parents = {}) {
  CatalogueEntry result{};
  std::strncpy(result.name, name, sizeof result.name - 1);
  result.spec = spec;
  std::fill(std::begin(result.parents), std::end(result.parents), int16_t{-1});
  std::copy(parents.begin(), parents.end(), result.parents);
  return result;
}

bool same(const Picture& a, const Picture& b) {
  if (a.width() != b.width() || a.height() != b.height()) return false;
  for (int y = 0; y < a.height(); ++y)
    if (std::memcmp(a.row(y), b.row(y), sizeof(Colour) * static_cast<size_t>(a.width())) != 0) return false;
  return true;
}

class Screen : public testing::Test {
 protected:
  Screen() : outlet_({Pixel::disparity16, 0, 64, 48}) {
    Image& image = outlet_.loan();
    image.camera = {580, 32, 24, 0.09f, 0, 0, 48, {}};
    for (int y = 0; y < 48; ++y) std::fill_n(image.row<int16_t>(y), 64, static_cast<int16_t>(16 * y));
    state_.entries = {entry("left", {Pixel::gray8, 0, 64, 48}), entry("disparity", image.spec, {0})};
    state_.shown = 1;
    state_.image = &image;
    state_.trust = Trust::fresh;
  }
  BufferOutlet outlet_;
  ScreenState state_;
};

TEST_F(Screen, holds_at_any_size_and_state) {
  for (int width : {1, 40, 360, 700, 1500}) {
    for (int height : {1, 60, 280, 900}) {
      for (Trust trust : {Trust::fresh, Trust::blind, Trust::stale, Trust::dead}) {
        for (bool image : {true, false}) {
          ScreenState state = state_;
          state.trust = trust;
          state.help = image;
          if (!image) state.image = nullptr;
          const Picture page = draw_screen(state, width, height);
          EXPECT_EQ(page.width(), width);
          EXPECT_EQ(page.height(), height);
        }
      }
    }
  }
  state_ = {};
  EXPECT_EQ(draw_screen(state_, 800, 600).width(), 800) << "no catalogue yet";
}

TEST_F(Screen, value_under_a_resting_cursor_follows_the_image) {
  state_.mouse_x = 200;
  state_.mouse_y = 200;
  const Picture before = draw_screen(state_, 700, 500);
  Image& image = outlet_.loan();
  for (int y = 0; y < 48; ++y) std::fill_n(image.row<int16_t>(y), 64, int16_t{100});
  const Picture after = draw_screen(state_, 700, 500);
  bool foot_differs = false;
  for (int y = 500 - 26; y < 500; ++y) foot_differs |= std::memcmp(before.row(y), after.row(y), sizeof(Colour) * 700) != 0;
  EXPECT_TRUE(foot_differs);
}

TEST_F(Screen, the_height_over_the_floor_is_told_beside_a_picture_of_its_size) {
  state_.mouse_x = 200;
  state_.mouse_y = 200;
  const Picture without = draw_screen(state_, 700, 500);
  BufferOutlet right({Pixel::height16, 0, 64, 48}), other({Pixel::height16, 0, 32, 24});
  for (int y = 0; y < 48; ++y) std::fill_n(right.loan().row<int16_t>(y), 64, int16_t{1234});
  state_.height = &right.loan();
  const Picture with = draw_screen(state_, 700, 500);
  EXPECT_FALSE(same(without, with));
  for (int y = 0; y < 48; ++y) std::fill_n(right.loan().row<int16_t>(y), 64, height_unknown);
  EXPECT_FALSE(same(draw_screen(state_, 700, 500), with));
  state_.height = &other.loan();
  EXPECT_TRUE(same(draw_screen(state_, 700, 500), without));
}

TEST_F(Screen, blind_stale_dead_and_fresh_look_different_and_frozen_says_so) {
  std::vector<Picture> pages;
  for (Trust trust : {Trust::fresh, Trust::blind, Trust::stale, Trust::dead}) {
    state_.trust = trust;
    pages.push_back(draw_screen(state_, 900, 600));
  }
  state_.frozen = true;
  pages.push_back(draw_screen(state_, 900, 600));
  for (size_t a = 0; a < pages.size(); ++a)
    for (size_t b = 0; b < a; ++b) EXPECT_FALSE(same(pages[a], pages[b])) << a << " and " << b;
}

class PanelTest : public testing::Test {
 protected:
  PanelTest() {
    state_.panel.open = true;
    for (const char* key : {"thresh", "unique", "SpeckleSize"})
      state_.panel.sliders.push_back(*Slider::of({key, "10", "10", "a number from 0 to 40 [-]", "-", "what it does", true, 0, 0}));
  }
  ScreenState state_;
};

TEST_F(PanelTest, holds_at_any_size) {
  for (int width : {1, 360, 592, 960, 1500})
    for (int height : {1, 60, 280, 620}) {
      for (size_t chosen : {size_t{0}, size_t{2}, size_t{99}}) {
        state_.panel.chosen = chosen;
        EXPECT_EQ(draw_screen(state_, width, height).width(), width);
      }
    }
}

TEST_F(PanelTest, value_choice_and_trouble_are_seen) {
  const Picture usual = draw_screen(state_, 960, 620);
  state_.panel.chosen = 1;
  const Picture chosen = draw_screen(state_, 960, 620);
  EXPECT_FALSE(same(usual, chosen));
  ParameterInfo info = state_.panel.sliders[1].info();
  info.value = "33";
  state_.panel.sliders[1].take(info);
  const Picture other = draw_screen(state_, 960, 620);
  EXPECT_FALSE(same(chosen, other));
  state_.panel.trouble = "nobody listens";
  EXPECT_FALSE(same(other, draw_screen(state_, 960, 620)));
  state_.panel.open = false;
  EXPECT_FALSE(same(usual, draw_screen(state_, 960, 620)));
}

TEST_F(PanelTest, the_mouse_finds_each_slider_once_from_its_least_to_its_greatest) {
  const Box room = panel_room(960, 620);
  std::set<size_t> found;
  for (int y = 0; y < 620; ++y) {
    EXPECT_FALSE(hit(room, state_.panel, room.x - 1, y)) << "that is the stage";
    const auto left = hit(room, state_.panel, room.x, y), right = hit(room, state_.panel, 959, y);
    ASSERT_EQ(left.has_value(), right.has_value());
    if (!left) continue;
    found.insert(left->slider);
    EXPECT_EQ(left->place, 0);
    EXPECT_EQ(right->place, 1);
  }
  EXPECT_EQ(found, (std::set<size_t>{0, 1, 2}));
  EXPECT_NEAR(place_along(room, room.x + room.width / 2), 0.5, 0.01);
}

TEST_F(PanelTest, a_chosen_one_below_the_others_is_brought_into_view) {
  for (int i = 0; i < 30; ++i) state_.panel.sliders.push_back(state_.panel.sliders[0]);
  state_.panel.chosen = state_.panel.sliders.size() - 1;
  const Box room = panel_room(960, 620);
  bool seen = false;
  for (int y = 0; y < 620; ++y) {
    const auto found = hit(room, state_.panel, room.x + 5, y);
    seen |= found && found->slider == state_.panel.chosen;
  }
  EXPECT_TRUE(seen);
}

TEST(Tree, each_stage_stands_once_below_its_first_input_and_names_the_others) {
  const ImageSpec spec{Pixel::gray8, 0, 4, 4};
  const std::vector<CatalogueEntry> entries{entry("a", spec), entry("b", spec), entry("d", spec, {0, 1}), entry("m", spec, {2, 0, 1})};
  const auto lines = tree_of(entries, true);
  ASSERT_EQ(lines.size(), 4u);
  EXPECT_EQ(lines[0].entry, 0u);
  EXPECT_EQ(lines[1].entry, 2u);
  EXPECT_EQ(lines[1].branch, "`-");
  EXPECT_EQ(lines[1].also, "+ b");
  EXPECT_EQ(lines[2].entry, 3u);
  EXPECT_EQ(lines[2].branch, "  `-");
  EXPECT_EQ(lines[2].also, "+ a, b");
  EXPECT_EQ(lines[3].entry, 1u);
}

TEST(Tree, an_input_of_the_last_frame_is_said_to_be_one) {
  const ImageSpec spec{Pixel::gray8, 0, 4, 4};
  const std::vector<CatalogueEntry> entries{entry("a", spec), entry("b", spec, {0, delayed_parent(1), delayed_parent(0)})};
  EXPECT_EQ(tree_of(entries, true).at(1).also, "+ last b, last a");
}

TEST(Tree, catalogue_that_makes_no_sense_still_shows_every_stage_once) {
  const ImageSpec spec{Pixel::gray8, 0, 4, 4};
  const std::vector<CatalogueEntry> entries{entry("self", spec, {0}), entry("later", spec, {2}),
                                            entry("loop", spec, {1, 99, -7, INT16_MIN})};
  std::set<size_t> seen;
  for (const TreeLine& line : tree_of(entries, false)) EXPECT_TRUE(seen.insert(line.entry).second);
  EXPECT_EQ(seen.size(), entries.size());
}

}  // namespace
}  // namespace vdisp
