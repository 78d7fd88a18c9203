// train_test.cpp: splits by whole drives, tables of trials cut off anywhere, training that does not depend on threads, plots.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <sysexits.h>

#include <fstream>
#include <iterator>
#include <numeric>
#include <set>

#include "daemon/tools/train/drives.h"
#include "daemon/tools/train/parallel.h"
#include "daemon/tools/train/plot.h"
#include "daemon/tools/train/report.h"
#include "daemon/tools/train/trials.h"
#include "daemon/tools/train/words.h"
#include "tests/support/temporary_folder.h"

namespace vdisp::train {
namespace {

std::string read(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::vector<snow::Source> numbered(int count) {
  std::vector<snow::Source> sources;
  for (int i = 0; i < count; ++i) sources.push_back({"drive" + std::to_string(i)});
  return sources;
}

/// Of no world of the simulator.
std::vector<std::string> none_of(const std::vector<snow::Source>& sources) { return std::vector<std::string>(sources.size()); }

TEST(HoldOut, takes_the_part_asked_and_leaves_collisions_to_train_with) {
  auto sources = numbered(30);
  sources.push_back({"collision", 3});
  hold_out(sources, none_of(sources), 0.2, 1);
  EXPECT_EQ(std::count_if(sources.begin(), sources.end(), [](const auto& source) { return source.held_apart; }), 6);
  EXPECT_FALSE(sources.back().held_apart);
}

TEST(HoldOut, depends_on_the_seed_and_reaches_every_drive) {
  std::set<size_t> reached;
  for (uint32_t seed = 1; seed < 60; ++seed) {
    auto once = numbered(10), again = numbered(10);
    hold_out(once, none_of(once), 0.2, seed);
    hold_out(again, none_of(again), 0.2, seed);
    EXPECT_EQ(once, again);
    for (size_t i = 0; i < once.size(); ++i)
      if (once[i].held_apart) reached.insert(i);
  }
  EXPECT_EQ(reached.size(), 10u);
}

TEST(HoldOut, refuses_to_leave_nothing_to_train_with) {
  auto one = numbered(1), none = numbered(0);
  EXPECT_THROW(hold_out(one, none_of(one), 0.2, 1), ToolError);
  EXPECT_THROW(hold_out(none, none_of(none), 0.2, 1), ToolError);
}

TEST(HoldOut, takes_a_world_whole_or_not_at_all) {
  std::vector<std::string> worlds;
  for (int i = 0; i < 20; ++i) worlds.push_back(i < 16 ? "office, seed " + std::to_string(2 * (i / 2)) : "");
  for (uint32_t seed = 1; seed < 30; ++seed) {
    auto sources = numbered(20);
    hold_out(sources, worlds, 0.2, seed);
    for (size_t i = 0; i < 16; i += 2) EXPECT_EQ(sources[i].held_apart, sources[i + 1].held_apart);
    const auto held = std::count_if(sources.begin(), sources.end(), [](const auto& source) { return source.held_apart; });
    EXPECT_TRUE(held == 4 || held == 5) << held;
  }
  auto sources = numbered(4);
  EXPECT_THROW(hold_out(sources, std::vector<std::string>(4, "office, seed 2"), 0.2, 1), ToolError) << "none would remain";
}

TEST(Thinning, keeps_about_as_many_of_each_part_of_each_drive) {
  Drives drives;
  drives.sources = numbered(2);
  for (uint32_t i = 0; i < 300; ++i) drives.samples.push_back({0, i, Label::forward});
  for (uint32_t i = 0; i < 100; ++i) drives.samples.push_back({1, i, Label::left});
  drives.thin(40);
  ASSERT_EQ(drives.samples.size(), 40u);
  EXPECT_EQ(drives.classes(false).forward, 30u);
  for (size_t i = 1; i < 30; ++i) EXPECT_EQ(drives.samples[i].pair - drives.samples[i - 1].pair, 10u);
}

TEST(Classes, name_what_is_missing) {
  EXPECT_EQ((Classes{1, 1, 1}.missing()), "");
  EXPECT_EQ((Classes{1, 0, 0}.missing()), "left and right");
  EXPECT_EQ((Classes{0, 2, 0}.missing()), "forward and right");
}

TEST(InParallel, does_each_task_once_and_throws_what_one_threw) {
  std::vector<std::atomic<int>> done(1000);
  in_parallel(3, done.size(), [&](size_t task, int) { ++done[task]; });
  for (const auto& count : done) EXPECT_EQ(count, 1);
  EXPECT_THROW(in_parallel(3, 100,
                           [](size_t task, int) {
                             if (task == 50) throw ToolError(66, "fifty");
                           }),
               ToolError);
}

class Table : public testing::Test {
 protected:
  static Trial trial(uint32_t block, double auc) {
    Trial made;
    made.settings.block = block;
    made.obstacle_auc = auc, made.direction_auc = 0.75;
    made.obstacle_sensitivity = -0.125, made.direction_sensitivity = 1.0 / 3;
    return made;
  }
  TemporaryFolder folder_;
  std::string path_ = (folder_ / "tune.csv").string();
};

TEST_F(Table, comes_back_as_it_was_written) {
  { TrialTable(path_, "q").add(trial(7, 0.987654321)); }
  const TrialTable table(path_, "q");
  ASSERT_EQ(table.trials().size(), 1u);
  EXPECT_EQ(table.trials()[0].obstacle_auc, 0.987654321);
  EXPECT_EQ(table.trials()[0].direction_sensitivity, 1.0 / 3);
  EXPECT_TRUE(table.has(trial(7, 0)));
  EXPECT_FALSE(table.has(trial(9, 0)));
}

TEST_F(Table, cut_off_at_any_byte_keeps_the_whole_lines_and_goes_on) {
  std::vector<size_t> ends;  // of the file after each trial
  {
    TrialTable table(path_, "q");
    ends.push_back(read(path_).size());
    for (const uint32_t block : {5, 7, 9}) table.add(trial(block, 0.5 + block / 100.0)), ends.push_back(read(path_).size());
  }
  const std::string whole = read(path_);
  for (size_t bytes = 0; bytes <= whole.size(); ++bytes) {
    std::ofstream(path_, std::ios::binary | std::ios::trunc) << whole.substr(0, bytes);
    {
      TrialTable table(path_, "q");
      const auto kept = static_cast<size_t>(std::count_if(ends.begin() + 1, ends.end(), [bytes](size_t end) { return end <= bytes; }));
      ASSERT_EQ(table.trials().size(), kept) << bytes;
      for (const uint32_t block : {5, 7, 9})
        if (!table.has(trial(block, 0))) table.add(trial(block, 0.5 + block / 100.0));
    }
    ASSERT_EQ(TrialTable(path_, "q").trials().size(), 3u) << bytes;
  }
}

TEST_F(Table, of_another_question_is_refused_and_kept) {
  { TrialTable(path_, "q").add(trial(7, 0.9)); }
  const std::string before = read(path_);
  EXPECT_THROW(TrialTable(path_, "other"), ToolError);
  EXPECT_EQ(read(path_), before);
}

TEST_F(Table, no_file_that_is_something_else_is_touched) {
  for (const char* text : {"{\"a\": 1}", "x", "# other", "{\n}\n", "# q, and more"}) {
    std::ofstream(path_, std::ios::binary | std::ios::trunc) << text;
    EXPECT_THROW(TrialTable(path_, "q"), ToolError) << text;
    EXPECT_EQ(read(path_), text);
  }
}

TEST_F(Table, with_a_line_that_is_no_trial_is_refused) {
  { TrialTable(path_, "q").add(trial(7, 0.9)); }
  std::ofstream(path_, std::ios::app) << "something else\n";
  EXPECT_THROW(TrialTable(path_, "q"), ToolError);
}

TEST(Verdicts, sensitivities_of_a_point_decide_as_the_point_does) {
  Judgement judgement;
  for (int i = 0; i < 200; ++i) {
    const bool positive = i % 3 == 0;
    const double score = (i * 7919 % 101) / 50.0 - 1 + (positive ? 0.6 : 0);
    judgement.obstacle.push_back({score, positive});
    judgement.direction.push_back({score, positive});
  }
  for (const snow::RocPoint& point : snow::roc_curve(judgement.obstacle)) {
    if (point.true_rate == 0) continue;  // the first one's threshold is infinite
    const Verdict obstacle = obstacle_verdict(judgement, obstacle_sensitivity_of(point));
    const Verdict direction = direction_verdict(judgement, direction_sensitivity_of(point));
    for (const Verdict& verdict : {obstacle, direction}) {
      EXPECT_DOUBLE_EQ(static_cast<double>(verdict.confusion.hits) / static_cast<double>(verdict.confusion.positives()), point.true_rate);
      EXPECT_DOUBLE_EQ(static_cast<double>(verdict.confusion.false_alarms) / static_cast<double>(verdict.confusion.negatives()),
                       point.false_rate);
    }
  }
}

// An untaught direction classifier says neither; the rule (difference + sensitivity > 0 is the first class) has to hold at the border too.
TEST(Verdicts, a_difference_of_zero_is_the_second_class) {
  Judgement judgement;
  judgement.obstacle = {{0, true}, {0, false}};
  judgement.direction = {{0, true}, {0, false}};
  EXPECT_EQ(obstacle_verdict(judgement, 0).confusion.hits, 1u);         // obstacle is the second class
  EXPECT_EQ(direction_verdict(judgement, 0).confusion.rejections, 1u);  // right is
}

TEST(Verdicts, clear_is_the_middle_of_the_free_pairs_that_look_free) {
  Judgement judgement;
  for (int i = 0; i < 101; ++i) judgement.obstacle.push_back({0.5 - 0.01 * i, false});  // differences -0.5 to 0.5
  for (int i = 0; i < 50; ++i) judgement.obstacle.push_back({-3, true});
  EXPECT_NEAR(clear_of(judgement), 0.26, 1e-9) << "of 0.01 to 0.5";
  EXPECT_EQ(clear_of({{{0.1, false}, {-3, true}}, {}}), 1) << "no free pair looks so";
  EXPECT_EQ(clear_of({}), 1);
}

TEST(Plots, are_the_same_each_time_and_hold_text_as_it_is) {
  const Plot plot{"a < b & c", "x", "y", {{"one", {{0, 0}, {0.2, 0.9}, {1, 1}}}}, true};
  EXPECT_EQ(svg_of(plot), svg_of(plot));
  EXPECT_NE(svg_of(plot).find("a &lt; b &amp; c"), std::string::npos);
  EXPECT_NE(svg_of(plot).find("80.00,550.00 180.00,100.00 580.00,50.00"), std::string::npos);  // 500 px a side, y upwards
  EXPECT_EQ(png_of(plot), png_of(plot));
}

}  // namespace
}  // namespace vdisp::train
