// parameters_test.cpp: the table of parameters is sound, and what is made from it is true and up to date.
// SPDX-License-Identifier: Apache-2.0
#include "config/parameters.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <random>
#include <set>
#include <sstream>

#include "config/cpu_list.h"
#include "config/reference.h"

namespace vdisp {
namespace {

namespace fs = std::filesystem;

std::string content(const fs::path& path) {
  std::ostringstream out;
  out << std::ifstream(path).rdbuf();
  return out.str();
}

std::string printed(const Config& config) {
  std::ostringstream out;
  print_config(out, config);
  return out.str();
}

TEST(Parameters, every_row_has_a_help_a_unit_and_a_default_in_its_range) {
  std::set<std::string> names;
  for (const Parameter& row : parameters()) {
    Config config;
    EXPECT_GT(row.help.size(), 10u) << row.name();
    EXPECT_TRUE(row.help.ends_with('.')) << row.name();
    EXPECT_TRUE(names.insert(row.name()).second) << row.name() << " is there twice";
    EXPECT_EQ(row.set(config, row.get(Config{})), std::nullopt) << row.name();
    if (row.kind == Kind::whole || row.kind == Kind::real) {
      EXPECT_FALSE(row.unit.empty()) << row.name();
      EXPECT_LT(row.least, row.most) << row.name();
    }
    if (row.kind == Kind::whole) {
      EXPECT_EQ(int(row.most - row.least) % row.step, 0) << row.name();
    }
  }
  for (const Section& section : sections()) EXPECT_GT(section.help.size(), 10u) << section.name;
}

TEST(Parameters, the_defaults_do_not_contradict_each_other) { EXPECT_TRUE(check(Config{}).empty()); }

TEST(Parameters, each_is_found_by_its_name_with_blanks_or_underscores) {
  for (const Parameter& row : parameters()) {
    EXPECT_EQ(find_parameter(row.name()), &row);
    std::string underscored = row.name();
    std::replace(underscored.begin(), underscored.end(), ' ', '_');
    EXPECT_EQ(find_parameter(underscored), &row);
  }
  EXPECT_EQ(find_parameter("Floor.ndisp"), nullptr);
  EXPECT_EQ(find_parameter("ndisp"), nullptr);
  EXPECT_EQ(find_parameter(""), nullptr);
}

TEST(Parameters, set_leaves_everything_as_it_was_when_it_refuses) {
  for (const Parameter& row : parameters()) {
    Config config;
    const std::string before = printed(config);
    EXPECT_TRUE(row.set(config, "no such\nvalue").has_value()) << row.name();
    EXPECT_EQ(printed(config), before) << row.name();
  }
}

TEST(Parameters, set_changes_its_own_value_alone) {
  for (const Parameter& row : parameters()) {
    Config config;
    std::string value;
    switch (row.kind) {
      case Kind::flag: value = row.get(config) == "yes" ? "no" : "yes"; break;
      case Kind::text:
      case Kind::path: value = "something"; break;
      case Kind::choice: value = row.words.substr(row.words.rfind('|') + 1); break;
      case Kind::whole: value = std::to_string(static_cast<int>(row.most)); break;
      case Kind::real: value = std::to_string(row.most); break;
    }
    if (row.key == "model") continue;  // one choice so far
    ASSERT_EQ(row.set(config, value), std::nullopt) << row.name() << " = " << value;
    for (const Parameter& other : parameters()) {
      const bool changed = other.get(config) != other.get(Config{});
      EXPECT_EQ(changed, &other == &row || (other.key == "angRot" && row.key == "angRot")) << other.name() << " by " << row.name();
    }
  }
}

TEST(Parameters, a_flag_takes_the_words_that_the_papers_framework_took) {
  const Parameter* loop = find_parameter("image source.loop");
  for (const char* yes : {"yes", "True", "ON", "1"}) {
    Config config;
    EXPECT_EQ(loop->set(config, yes), std::nullopt);
    EXPECT_TRUE(config.image_source.loop) << yes;
    for (const char* no : {"no", "fAlse", "Off", "0"}) {
      config.image_source.loop = true;
      EXPECT_EQ(loop->set(config, no), std::nullopt);
      EXPECT_FALSE(config.image_source.loop) << no;
    }
  }
}

/// A value that the row takes. Paths are absolute, as they are once read.
std::string any_value(const Parameter& row, std::mt19937& random) {
  Config config;
  const auto below = [&](size_t n) { return static_cast<size_t>(random()) % n; };
  if (row.kind == Kind::flag) return below(2) ? "yes" : "no";
  if (row.kind == Kind::choice || (!row.words.empty() && below(4) == 0)) {
    std::vector<std::string> words;
    std::istringstream in{std::string(row.words)};
    for (std::string word; std::getline(in, word, '|');) words.push_back(word);
    return words[below(words.size())];
  }
  if (row.kind == Kind::whole) {
    return std::to_string(int(row.least) + row.step * int(below(size_t(row.most - row.least) / size_t(row.step) + 1)));
  }
  if (row.kind == Kind::real) {
    std::ostringstream out;
    out.precision(17);
    out << std::uniform_real_distribution<double>(row.least, row.most)(random);
    return out.str();
  }
  const std::string letters = "abc \"'\\$#;=[]{}%\xc3\xa9";
  std::string text = row.kind == Kind::path ? "/" : "n";
  for (size_t n = below(30); n > 0; --n) text += letters[below(letters.size())];
  return text;
}

TEST(CpuList, numbers_and_ranges_are_read_and_written_back) {
  EXPECT_EQ(cpu_list("0,2-3"), (std::set<int>{0, 2, 3}));
  EXPECT_EQ(cpu_list(" 5 , 1 - 2 ,5"), (std::set<int>{1, 2, 5}));
  EXPECT_EQ(text_of({0, 1, 2, 4, 6, 7}), "0-2,4,6-7");
  EXPECT_EQ(text_of({}), "");
  for (const char* wrong : {"", ",", "1,", "-1", "1-", "3-1", "x", "1.5", "1024", "0-99999999999"})
    EXPECT_EQ(cpu_list(wrong), std::nullopt) << wrong;
}

TEST(Parameters, what_is_printed_reads_back_to_the_same) {
  char folder[] = "/tmp/vdisp_print_XXXXXX";
  ASSERT_NE(mkdtemp(folder), nullptr);
  const fs::path file = fs::path(folder) / "printed.cfg";
  std::mt19937 random(7);
  int tried = 0;
  for (int round = 0; round < 500; ++round) {
    Config config, again;
    for (const Parameter& row : parameters()) {
      const std::string value = any_value(row, random);
      ASSERT_EQ(row.set(config, value), std::nullopt) << row.name() << " = " << value;
    }
    config.floor.anglefloorMin = config.floor.anglefloorMax / 2;
    config.map.cell = std::max(config.map.cell, 0.05);
    config.image_source.width = config.image_source.height = 0;
    config.decide.leastSpeed = config.decide.speed / 2;
    config.decide.near = config.decide.far / 2;
    config.main.cpus = round % 2 ? "0, 2-3" : "";
    if (!check(config).empty()) continue;
    ++tried;
    std::ofstream(file) << printed(config);
    const ConfigReading reading = read_config(file, {}, again);
    ASSERT_TRUE(reading.complaints.empty()) << reading.complaints[0];
    for (const Parameter& row : parameters()) ASSERT_EQ(row.get(again), row.get(config)) << row.name();
    ASSERT_EQ(printed(again), printed(config));
  }
  EXPECT_GT(tried, 100);
  fs::remove_all(folder);
}

TEST(Parameters, numbers_are_printed_to_the_last_bit) {
  Config config;
  const Parameter* cell = find_parameter("Map.cell");
  config.map.cell = 0.1;
  EXPECT_EQ(cell->get(config), "0.1");
  config.map.cell = 0.1 + 0.2;
  EXPECT_EQ(cell->get(config), "0.30000000000000004");
}

TEST(Parameters, what_was_changed_is_marked) {
  EXPECT_EQ(printed(Config{}).find("changed here"), std::string::npos);
  Config config;
  config.floor.iterRansac = 500;
  const std::string text = printed(config);
  const size_t mark = text.find("changed here\niterRansac = 500\n");
  EXPECT_NE(mark, std::string::npos);
  EXPECT_EQ(text.find("changed here"), mark);
}

TEST(Parameters, the_shipped_file_is_the_defaults) {
  const fs::path shipped = fs::path(VDISP_SOURCE_DIR) / "config/vdisp.cfg";
  EXPECT_EQ(content(shipped), printed(Config{})) << "run scripts/update-reference";
  Config config;
  config.floor.iterRansac = 11;
  EXPECT_EQ(read_config(shipped, {}, config).exit_code, 0);
  EXPECT_EQ(printed(config), printed(Config{}));
}

TEST(Parameters, the_manual_page_is_current) {
  std::ostringstream page;
  write_man_page(page);
  EXPECT_EQ(content(fs::path(VDISP_SOURCE_DIR) / "docs/man/vdisp.cfg.5"), page.str()) << "run scripts/update-reference";
}

TEST(Parameters, the_page_of_parameters_is_current) {
  std::ostringstream page;
  write_markdown(page);
  EXPECT_EQ(content(fs::path(VDISP_SOURCE_DIR) / "docs/parameters.md"), page.str()) << "run scripts/update-reference";
}

TEST(Parameters, manual_and_page_name_every_parameter_with_its_range) {
  std::ostringstream manual, page;
  write_man_page(manual);
  write_markdown(page);
  for (const Parameter& row : parameters()) {
    EXPECT_NE(manual.str().find(".B " + std::string(row.key) + "\n"), std::string::npos) << row.name();
    EXPECT_NE(page.str().find("| `" + std::string(row.key) + "` |"), std::string::npos) << row.name();
    EXPECT_NE(printed(Config{}).find("\n" + std::string(row.key) + " = "), std::string::npos) << row.name();
  }
}

TEST(Parameters, groff_has_nothing_to_say_of_the_manual_page) {
  if (std::system("command -v groff >/dev/null 2>&1") != 0) GTEST_SKIP() << "no groff here";
  const std::string page = std::string(VDISP_SOURCE_DIR) + "/docs/man/vdisp.cfg.5";
  EXPECT_EQ(std::system(("test -z \"$(groff -man -Tutf8 -ww -z '" + page + "' 2>&1)\"").c_str()), 0);
}

}  // namespace
}  // namespace vdisp
