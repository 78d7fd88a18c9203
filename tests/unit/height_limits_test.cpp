// height_limits_test.cpp: what made a pixel its surface where its height does not.
// SPDX-License-Identifier: Apache-2.0
#include "probe/height_limits.h"

#include <gtest/gtest.h>

namespace vdisp {
namespace {

TEST(HeightLimits, what_the_height_does_not_say_is_told) {
  const HeightLimits limits{0.2, 2};
  const auto told = [&](double height, Surface surface) { return beyond_height(height, surface, limits); };
  EXPECT_EQ(told(0.1, Surface::floor), "");
  EXPECT_NE(told(0.5, Surface::floor).find("leads up to it"), std::string::npos);
  EXPECT_EQ(told(0.3, Surface::obstacle), "");
  EXPECT_NE(told(0.1, Surface::obstacle).find("upright"), std::string::npos);
  EXPECT_EQ(told(-0.3, Surface::below), "");
  EXPECT_NE(told(-0.1, Surface::below).find("ditch"), std::string::npos);
  EXPECT_NE(told(0.1, Surface::none).find("low part"), std::string::npos);
  EXPECT_EQ(told(2.5, Surface::overhang), "");
}

TEST(HeightLimits, nothing_is_made_up_where_they_are_not_known) {
  EXPECT_EQ(beyond_height(0.5, Surface::floor, {}), "");
  EXPECT_EQ(beyond_height(NAN, Surface::floor, {0.2, 2}), "");
  EXPECT_FALSE(limits_of("/nothing/listens/here").known());
}

}  // namespace
}  // namespace vdisp
