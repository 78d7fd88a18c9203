// vdisparity_test.cpp: votes are counted the same at every level, and as the contract says.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/kernels/vdisparity.h"

#include "tests/kernels/disparities.h"

namespace vdisp::kernels {
namespace {

/// Scratch with a guard behind it.
class Scratch {
 public:
  explicit Scratch(int width) : memory_(vote_scratch(width) + 16, uint16_t{0x5A5A}) {}
  uint16_t* data() { return memory_.data(); }
  bool damaged() const {
    return std::any_of(memory_.end() - 16, memory_.end(), [](uint16_t x) { return x != 0x5A5A; });
  }

 private:
  std::vector<uint16_t> memory_;
};

TEST(CountVotes, is_the_same_at_every_level) {
  at_each_level([](const std::string&, const Kernels& k) {
    for (const auto& [width, height] : awkward_sizes) {
      for (const Search& search : searches) {
        for (Scene scene : all_scenes) {
          Picture<int16_t> disparity(width, height), expected(search.columns + 3, height), got(search.columns + 3, height);
          fill(disparity, scene, search, static_cast<uint32_t>(width * 31 + height));
          Scratch scratch(width);
          plain::count_votes(disparity.view(), 0, height, search, expected.plane(), scratch.data());
          k.count_votes(disparity.view(), 0, height, search, got.plane(), scratch.data());
          ASSERT_EQ(expected, got) << width << "x" << height << " from " << search.first << " scene " << static_cast<int>(scene);
          ASSERT_EQ(got.damage(), "");
          ASSERT_FALSE(scratch.damaged());
        }
      }
    }
  });
}

TEST(CountVotes, each_pixel_that_counts_is_one_vote_in_its_row_and_column) {
  const Search search{160, 163, 64};
  Picture<int16_t> disparity(200, 5), votes(64, 5);
  fill(disparity, Scene::rejected, search, 1);
  for (int x : {3, 77, 78, 79, 199}) disparity.at(x, 2) = 170;
  disparity.at(5, 2) = 162;  // at infinity
  disparity.at(6, 2) = 224;  // beyond the search
  disparity.at(7, 2) = 223;
  Scratch scratch(200);
  const auto check = [&](const Kernels& k) {
    k.count_votes(disparity.view(), 0, 5, search, votes.plane(), scratch.data());
    for (int y = 0; y < 5; ++y)
      for (int x = 0; x < 64; ++x) ASSERT_EQ(votes.at(x, y), y != 2 ? 0 : x == 10 ? 5 : x == 63 ? 1 : 0) << x << "," << y;
  };
  check(kernels("plain"));
  at_each_level([&](const std::string&, const Kernels& k) { check(k); });
}

TEST(CountVotes, a_count_stays_at_its_most) {
  const Search search{0, 1, 16};
  for (int width : {32767, 32768, 65535}) {
    Picture<int16_t> disparity(width, 5), votes(16, 5);
    fill(disparity, Scene::one_value, search, 1);
    Scratch scratch(width);
    const auto check = [&](const Kernels& k) {
      k.count_votes(disparity.view(), 0, 5, search, votes.plane(), scratch.data());
      for (int y = 0; y < 5; ++y) ASSERT_EQ(votes.at(15, y), 32767) << width;
      for (int y = 0; y < 5; ++y) ASSERT_EQ(votes.at(14, y), 0) << width;
    };
    check(kernels("plain"));
    at_each_level([&](const std::string&, const Kernels& k) { check(k); });
  }
}

TEST(CountVotes, touches_only_the_rows_asked_for) {
  const Search search{0, 1, 256};
  at_each_level([&](const std::string&, const Kernels& k) {
    for (const auto& [first, last] : {std::pair{3, 4}, {2, 9}, {0, 5}, {7, 7}}) {
      Picture<int16_t> disparity(70, 11), whole(256, 11), votes(256, 11), untouched(256, 11);
      fill(disparity, Scene::mixed, search, 5);
      Scratch scratch(70);
      plain::count_votes(disparity.view(), 0, 11, search, whole.plane(), scratch.data());
      k.count_votes(disparity.view(), first, last, search, votes.plane(), scratch.data());
      for (int y = 0; y < 11; ++y) {
        Picture<int16_t>& expected = y >= first && y < last ? whole : untouched;
        for (int x = 0; x < 256; ++x) ASSERT_EQ(votes.at(x, y), expected.at(x, y)) << x << "," << y;
      }
    }
  });
}

}  // namespace
}  // namespace vdisp::kernels
