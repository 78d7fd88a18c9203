// no_malloc_test.cpp: after start-up the loop takes nothing from the heap.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "daemon/log/edges.h"
#include "daemon/log/log.h"
#include "daemon/tree.h"
#include "tests/support/own_allocations.h"

namespace vdisp {
namespace {

struct NoMallocTest : testing::TestWithParam<const char*> {};

TEST_P(NoMallocTest, the_loop_takes_nothing_from_the_heap_with_every_stage_on) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "the sanitizer has its own malloc";
#endif
  Config config;
  config.image_source.source = "sim";
  config.image_source.matcher = GetParam();
  if (config.image_source.matcher == "census") config.image_source.smooth = "median";
  config.sim.rate = 0;
  config.sim.width = 320;
  config.sim.height = 240;
  log::start(0);
  log::Edges edges(config, [] { return std::string_view(); });
  Inputs inputs(config);
  Machine machine(2);
  Driver driver(1);
  build_tree(driver, open_source(config), machine, config, inputs);
  driver.connect([](const std::string&, const ImageSpec& spec) { return std::make_unique<BufferOutlet>(spec); });
  driver.need_all();
  driver.set_viewer([&](const Topic& topic, const Image& image) { edges.see(topic, image); });
  for (int i = 0; i < 5; ++i) ASSERT_EQ(driver.step(), Outcome::valid);
  CountAllocations count;
  for (int i = 0; i < 100; ++i) {
    driver.step();
    driver.beat();
  }
  const Allocations found = count.end();
  log::stop();
  EXPECT_EQ(found.own, 0u) << "the first one:\n" << found.first;
  if (!std::string_view(GetParam()).starts_with("opencv")) {
    EXPECT_EQ(found.opencv, 0u) << "with our own matcher nothing at all allocates";
  } else {
    EXPECT_GT(found.opencv, 0u) << "the count does not work: OpenCV's matchers are known to allocate";
  }
  RecordProperty("opencv_allocations_per_frame", static_cast<int>(found.opencv / 100));
}

INSTANTIATE_TEST_SUITE_P(Matchers, NoMallocTest, testing::Values("bm", "census", "opencv", "opencv-sgbm"), [](const auto& test) {
  return std::string(test.param) == "opencv-sgbm" ? std::string("opencv_sgbm") : std::string(test.param);
});

}  // namespace
}  // namespace vdisp
