// change_test.cpp: one parameter set by its name, and the file written anew.
// SPDX-License-Identifier: Apache-2.0
#include "config/change.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

namespace vdisp {
namespace {

using Values = std::vector<std::pair<const Parameter*, std::string>>;

TEST(ChangeTest, a_key_is_found_with_its_section_or_alone_where_one_section_has_it) {
  std::string complaint;
  EXPECT_EQ(named_parameter("image source.thresh", complaint), find_parameter("image source.thresh"));
  EXPECT_EQ(named_parameter("image_source.thresh", complaint), find_parameter("image source.thresh"));
  EXPECT_EQ(named_parameter("thresh", complaint), find_parameter("image source.thresh"));
  EXPECT_EQ(named_parameter("angRot", complaint), find_parameter("Limit obstacle.angRot")) << "one value in two sections";
  EXPECT_EQ(complaint, "");
  EXPECT_EQ(named_parameter("width", complaint), nullptr);
  EXPECT_NE(complaint.find("[Map]"), complaint.npos) << complaint;
  EXPECT_EQ(named_parameter("Map.minCont", complaint), nullptr);
  EXPECT_NE(complaint.find("'minCount'"), complaint.npos) << complaint;
  EXPECT_EQ(named_parameter("Mop.minCount", complaint), nullptr);
  EXPECT_EQ(named_parameter("", complaint), nullptr);
}

TEST(ChangeTest, a_value_out_of_range_or_against_another_is_refused_in_the_files_words_and_changes_nothing) {
  Config config;
  EXPECT_EQ(change(config, *find_parameter("image source.thresh"), "20"), "");
  EXPECT_EQ(config.image_source.thresh, 20);
  EXPECT_EQ(change(config, *find_parameter("image source.thresh"), "99"), "thresh = 99, must be a number from 0 to 40 [-], default 10");
  EXPECT_EQ(config.image_source.thresh, 20);
  EXPECT_EQ(change(config, *find_parameter("Floor.anglefloorMin"), "1.2"), "anglefloorMin = 1.2, must be less than anglefloorMax = 0.9");
  EXPECT_EQ(config.floor.anglefloorMin, 0.1);
  EXPECT_EQ(change(config, *find_parameter("Map.angRot"), "\"0.3\""), "") << "quotes as in the file; both sections follow";
  EXPECT_EQ(config.limit.angRot, 0.3);
}

TEST(ChangeTest, exchange_swaps_one_value_and_angRot_in_both_sections) {
  Config one, other;
  other.map.angRot = other.limit.angRot = 0.5;
  other.map.minCount = 7;
  other.image_source.smooth = "median";
  find_parameter("Map.angRot")->exchange(one, other);
  EXPECT_EQ(one.limit.angRot, 0.5);
  EXPECT_EQ(one.map.angRot, 0.5);
  EXPECT_EQ(one.map.minCount, 3);
  find_parameter("image source.smooth")->exchange(one, other);
  EXPECT_EQ(one.image_source.smooth, "median");
}

TEST(RewrittenTest, only_the_value_changes_and_comments_order_and_blanks_stay) {
  const std::string before = "# mine\n\n[image source]\n  thresh =   10   # texture\nunique=5\r\n[Map]\nminCount = \"3\" ; cells\n";
  const Values values{{find_parameter("image source.thresh"), "20"}, {find_parameter("Map.minCount"), "4"}};
  EXPECT_EQ(rewritten(before, values), "# mine\n\n[image source]\n  thresh =   20   # texture\nunique=5\r\n[Map]\nminCount = 4 ; cells\n");
  EXPECT_EQ(rewritten(before, Values{{find_parameter("image source.unique"), "7"}}),
            "# mine\n\n[image source]\n  thresh =   10   # texture\nunique=7\r\n[Map]\nminCount = \"3\" ; cells\n");
}

TEST(RewrittenTest, a_key_of_another_section_or_in_a_comment_is_left_alone) {
  const std::string before = "[sim]\nwidth = 320\n# height = 1\n[Map]\nwidth = 4\n";
  EXPECT_EQ(rewritten(before, Values{{find_parameter("Map.width"), "5"}}), "[sim]\nwidth = 320\n# height = 1\n[Map]\nwidth = 5\n");
}

TEST(RewrittenTest, a_missing_key_is_added_to_its_section_and_a_missing_section_to_the_file) {
  const Values values{{find_parameter("Map.minCount"), "4"}};
  EXPECT_EQ(rewritten("[Map]\ncell = 0.2\n# the rest\n[sim]\nseed = 2\n", values),
            "[Map]\ncell = 0.2\nminCount = 4\n# the rest\n[sim]\nseed = 2\n");
  EXPECT_EQ(rewritten("[Map]\n", values), "[Map]\nminCount = 4\n");
  EXPECT_EQ(rewritten("[sim]\nseed = 2", values), "[sim]\nseed = 2\n\n[Map]\nminCount = 4\n");
  EXPECT_EQ(rewritten("", values), "[Map]\nminCount = 4\n");
}

TEST(RewrittenTest, a_value_behind_a_colon_and_a_section_behind_a_byte_order_mark_are_found) {
  const Values values{{find_parameter("image source.thresh"), "20"}, {find_parameter("image source.unique"), "7"}};
  EXPECT_EQ(rewritten("\xef\xbb\xbf[image source]\nthresh: 10 # texture\nunique =5\n[sim]\nsize : 2\n", values),
            "\xef\xbb\xbf[image source]\nthresh: 20 # texture\nunique =7\n[sim]\nsize : 2\n");
}

TEST(RewrittenTest, angRot_changes_in_each_section_that_has_it) {
  const Values both{{find_parameter("Limit obstacle.angRot"), "0.3"}, {find_parameter("Map.angRot"), "0.3"}};
  EXPECT_EQ(rewritten("[Limit obstacle]\nangRot=0.2\n[Map]\nangRot=0.2\n", both), "[Limit obstacle]\nangRot=0.3\n[Map]\nangRot=0.3\n");
  EXPECT_EQ(rewritten("[Map]\nangRot=0.2\n", both), "[Map]\nangRot=0.3\n");
}

TEST(RewrittenTest, the_shipped_file_reads_back_to_what_was_written) {
  Config config;
  std::string complaint;
  Values values;
  for (const Parameter& row : parameters())
    if (row.when == When::live && row.kind == Kind::whole) values.emplace_back(&row, std::to_string(static_cast<int>(row.least)));
  std::ostringstream file;
  print_config(file, config);
  const std::string before = file.str(), text = rewritten(before, values);
  for (const auto& [row, value] : values)
    EXPECT_NE(text.find("\n" + std::string(row->key) + " = " + value + "\n"), text.npos) << row->name();
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), std::count(before.begin(), before.end(), '\n')) << "no line more or less";
}

}  // namespace
}  // namespace vdisp
