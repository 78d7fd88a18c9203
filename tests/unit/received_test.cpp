// received_test.cpp: what a client believes of shared memory: no header makes it read beyond its bytes, no clock makes old images fresh.
// SPDX-License-Identifier: Apache-2.0
#include "ipc/received.h"

#include <gtest/gtest.h>

#include <cstring>

#include "ipc/outlet.h"

namespace vdisp {
namespace {

constexpr int64_t ms = 1'000'000, now = 1'000'000 * ms;

struct HeaderTest : testing::Test {
  BufferOutlet outlet{ImageSpec{Pixel::count16, 0, 40, 10}};
  Image& image = outlet.loan();
  const uint64_t bytes = image.spec.bytes();
  const Image* found() const { return image_in(&image, bytes); }
};

TEST_F(HeaderTest, an_image_in_its_bytes_is_one_and_in_fewer_is_none) {
  EXPECT_EQ(found(), &image);
  for (const uint64_t fewer : {bytes - 1, uint64_t{sizeof(Image)}, uint64_t{sizeof(Image) - 1}, uint64_t{0}})
    EXPECT_EQ(image_in(&image, fewer), nullptr) << fewer;
  EXPECT_EQ(image_in(reinterpret_cast<const std::byte*>(&image) + 8, bytes), nullptr) << "not on a border of 64";
}

TEST_F(HeaderTest, magic_version_reason_and_kind_of_pixel_are_known) {
  const auto refused_with = [&](auto change) {
    alignas(Image) std::byte kept[sizeof(Image)];
    std::memcpy(kept, static_cast<const void*>(&image), sizeof kept);
    change();
    const bool refused = found() == nullptr;
    std::memcpy(static_cast<void*>(&image), kept, sizeof kept);
    return refused;
  };
  EXPECT_TRUE(refused_with([&] { image.magic = 0; }));
  EXPECT_TRUE(refused_with([&] { image.version = 2; }));
  EXPECT_TRUE(refused_with([&] { image.reason = Reason::count; }));
  EXPECT_TRUE(refused_with([&] { image.spec.pixel = Pixel::none; }));
  EXPECT_TRUE(refused_with([&] { image.spec.pixel = static_cast<Pixel>(10); }));
  EXPECT_EQ(found(), &image);
}

TEST_F(HeaderTest, an_image_without_rows_or_columns_is_none_and_none_is_so_large_that_sizes_overflow) {
  image.spec = {Pixel::line16, 0, 640, 0};
  EXPECT_EQ(found(), nullptr) << "a curve is read from row 0";
  image.spec = {Pixel::count16, 0, 0, 10};
  EXPECT_EQ(found(), nullptr) << "a plan is divided by its columns";
  image.spec = {Pixel::record, 0, 16, 2};
  EXPECT_EQ(found(), nullptr);
  image.spec = {Pixel::gray8, 0, longest_side, longest_side};
  EXPECT_NE(image_in(&image, uint64_t{1} << 40), nullptr) << "not that anything of it was read";
  image.spec.width = longest_side + 1;
  EXPECT_EQ(image_in(&image, uint64_t{1} << 40), nullptr);
  image.spec = {Pixel::rgb8, 0, 65535, 65535};
  EXPECT_EQ(found(), nullptr);
}

struct TrustTest : testing::Test {
  BufferOutlet outlet{ImageSpec{Pixel::gray8, 0, 4, 4}};
  Image& image = outlet.loan();
  Beat beat{5, now - 100 * ms, 33 * ms};
  TrustTest() {
    image.epoch = 5;
    image.ready_ns = now - 20 * ms;
  }
  Trust trust() const { return judged(&image, beat, now).trust; }
};

TEST_F(TrustTest, recent_is_fresh_old_is_stale_and_a_silent_daemon_is_dead) {
  EXPECT_EQ(trust(), Trust::fresh);
  EXPECT_NEAR(judged(&image, beat, now).age_s, 0.02, 1e-9);
  image.ready_ns = now - 301 * ms;
  EXPECT_EQ(trust(), Trust::stale);
  beat.period_ns = 200 * ms;
  EXPECT_EQ(trust(), Trust::fresh) << "three periods";
  beat.ready_ns = now - 1001 * ms;
  EXPECT_EQ(trust(), Trust::dead);
  EXPECT_EQ(judged(nullptr, {5, now, 0}, now).trust, Trust::stale);
  EXPECT_EQ(judged(nullptr, {}, now).trust, Trust::dead);
}

TEST_F(TrustTest, what_is_of_a_time_to_come_is_not_fresh_for_ever) {
  image.ready_ns = now + 5 * ms;
  EXPECT_EQ(trust(), Trust::fresh) << "the reader looked at its clock before";
  image.ready_ns = now + 301 * ms;
  EXPECT_EQ(trust(), Trust::stale);
  for (const int64_t any : {INT64_MAX, INT64_MIN}) {
    image.ready_ns = any;
    EXPECT_EQ(trust(), Trust::stale);
    image.ready_ns = now;
    beat.ready_ns = any;
    EXPECT_EQ(trust(), Trust::dead);
    beat.ready_ns = now;
  }
}

TEST_F(TrustTest, what_another_daemon_made_is_dead) {
  image.epoch = 4;
  EXPECT_EQ(trust(), Trust::dead);
}

TEST(CatalogueTest, names_end_and_inputs_are_entries_whatever_the_record_says) {
  Catalogue catalogue;
  std::memset(static_cast<void*>(&catalogue), 0x7f, sizeof catalogue);  // a count of two thousand million, names without an end
  std::vector<CatalogueEntry> entries = entries_of(catalogue);
  ASSERT_EQ(entries.size(), Catalogue::capacity);
  for (const CatalogueEntry& entry : entries) {
    EXPECT_EQ(std::strlen(entry.name), sizeof entry.name - 1);
    for (const int16_t parent : entry.parents) EXPECT_EQ(parent, -1);
  }
  catalogue.count = 3;
  const int16_t parents[] = {2, 3, delayed_parent(2), INT16_MIN};
  std::copy(std::begin(parents), std::end(parents), catalogue.entries[0].parents);
  entries = entries_of(catalogue);
  ASSERT_EQ(entries.size(), 3u);
  EXPECT_EQ(entries[0].parents[0], 2);
  EXPECT_EQ(entries[0].parents[1], -1);
  EXPECT_EQ(entries[0].parents[2], delayed_parent(2));
  EXPECT_EQ(entries[0].parents[3], -1);
}

}  // namespace
}  // namespace vdisp
