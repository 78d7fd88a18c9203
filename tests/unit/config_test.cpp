// config_test.cpp: vdisp.cfg is read as it is meant, and everything wrong with it is said, with file and line.
// SPDX-License-Identifier: Apache-2.0
#include "config/config.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sysexits.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <random>
#include <sstream>

#include "config/parameters.h"
#include "config/suggestion.h"

namespace vdisp {
namespace {

namespace fs = std::filesystem;

class ConfigFile : public testing::Test {
 protected:
  void SetUp() override {
    char name[] = "/tmp/vdisp_config_XXXXXX";
    ASSERT_NE(mkdtemp(name), nullptr);
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path file() const { return folder_ / "t.cfg"; }
  void write(const std::string& text) const { std::ofstream(file(), std::ios::binary) << text; }

  ConfigReading read(const std::string& text, const std::vector<std::string>& sets = {}) {
    write(text);
    config_ = Config{};
    return read_config(file(), sets, config_);
  }
  /// As the operator sees them, the folder left out.
  std::string complaints(const std::string& text, const std::vector<std::string>& sets = {}) { return said(read(text, sets)); }
  std::string said(const ConfigReading& reading) const {
    std::ostringstream out;
    for (const Complaint& complaint : reading.complaints) out << complaint << '\n';
    std::string text = out.str();
    const std::string prefix = folder_.string() + "/";
    for (size_t at; (at = text.find(prefix)) != text.npos;) text.erase(at, prefix.size());
    return text;
  }

  fs::path folder_;
  Config config_;
};

std::string printed(const Config& config) {
  std::ostringstream out;
  print_config(out, config);
  return out.str();
}

// The file in appendix C of the report on the CRAB rover, 2009.
constexpr const char* papers_file = R"([main]
middleware = "ddx"
period = 0
debug = 1

[image source]
width=640
height=480
ndisp=48
corrsize=11
thresh=10
unique=10
SpeckleSize=100
SpeckleDiff=4
paramfile="/home/chautemc/Project/IPipeline/ObstacleDetection/Calibration/calibration.ini"

[Floor]
minRansac=100
iterRansac=100
anglefloorMin=0.1
anglefloorMax=0.9
distThres=4

[Limit obstacle]
max_height=0.20
angRot=0.26

[Map]
angRot=0.26
)";

TEST_F(ConfigFile, the_papers_file_is_read_unmodified) {
  EXPECT_EQ(complaints(papers_file), "");
  EXPECT_EQ(config_.main.middleware, "ddx");
  EXPECT_EQ(config_.image_source.width, 640);
  EXPECT_EQ(config_.image_source.height, 480);
  EXPECT_EQ(config_.image_source.SpeckleDiff, 4);
  EXPECT_EQ(config_.image_source.paramfile, "/home/chautemc/Project/IPipeline/ObstacleDetection/Calibration/calibration.ini");
  EXPECT_EQ(config_.floor.anglefloorMax, 0.9);
  EXPECT_EQ(config_.limit.max_height, 0.2);
  EXPECT_EQ(config_.map.angRot, 0.26);
}

TEST_F(ConfigFile, coorsize_of_the_papers_table_is_corrsize_with_a_note) {
  const ConfigReading reading = read("[image source]\ncoorsize = 13\n");
  EXPECT_EQ(said(reading), "");
  EXPECT_EQ(config_.image_source.corrsize, 13);
  ASSERT_EQ(reading.notes.size(), 1u);
  EXPECT_EQ(reading.notes[0].line, 2);
  EXPECT_EQ(complaints("[image source]\ncorrsize=11\ncoorsize=13\n"),
            "t.cfg:3: corrsize stands twice in [image source], first in line 2\n");
}

TEST_F(ConfigFile, an_empty_file_is_the_defaults) {
  EXPECT_EQ(complaints(""), "");
  EXPECT_EQ(printed(config_), printed(Config{}));
  EXPECT_EQ(complaints("\n  \n# nothing\n[Floor]\n"), "");
}

TEST_F(ConfigFile, no_file_is_the_defaults_and_options) {
  EXPECT_EQ(read_config("", std::vector<std::string>{"Floor.iterRansac=77"}, config_).exit_code, 0);
  EXPECT_EQ(config_.floor.iterRansac, 77);
}

TEST_F(ConfigFile, a_value_out_of_range_is_named_with_its_range_and_default) {
  EXPECT_EQ(complaints("[Floor]\n\niterRansac = 9999\n"),
            "t.cfg:3: iterRansac = 9999, must be a number from 10 to 2000 [-], default 100\n");
  EXPECT_EQ(complaints("[image source]\nndisp=50\n"),
            "t.cfg:2: ndisp = 50, must be a number from 16 to 256 in steps of 16 [pixel], default 48\n");
  EXPECT_EQ(complaints("[image source]\nndisp=48.5\n"),
            "t.cfg:2: ndisp = 48.5, must be a whole number from 16 to 256 in steps of 16 [pixel], default 48\n");
  EXPECT_EQ(complaints("[Map]\nangRot=1.3\n"), "t.cfg:2: angRot = 1.3, must be a number from -0.5 to 1.2 [rad] or auto, default 0.26\n");
  EXPECT_EQ(complaints("[image source]\nsource=fils\n"),
            "t.cfg:2: source = fils, must be auto, sim, files, aravis, v4l2 or dc1394, default auto\n");
  EXPECT_EQ(complaints("[image source]\nloop=maybe\n"), "t.cfg:2: loop = maybe, must be yes or no, default no\n");
  EXPECT_EQ(complaints("[Floor]\niterRansac =\n"), "t.cfg:2: iterRansac has no value, must be a number from 10 to 2000 [-], default 100\n");
}

TEST_F(ConfigFile, every_edge_of_every_range_is_taken_and_beyond_it_refused) {
  for (const Parameter& row : parameters()) {
    if (row.kind != Kind::whole && row.kind != Kind::real) continue;
    for (const double edge : {row.least, row.most}) {
      std::ostringstream at, beyond;
      at.precision(9);
      beyond.precision(9);
      at << edge;
      beyond << (edge == row.least ? edge - 1 : edge + 1);
      Config config;
      EXPECT_EQ(row.set(config, at.str()), std::nullopt) << row.name();
      EXPECT_TRUE(row.set(config, beyond.str()).has_value()) << row.name() << " = " << beyond.str();
      EXPECT_EQ(std::stod(row.get(config)), edge) << row.name();
    }
  }
}

TEST_F(ConfigFile, what_is_not_quite_a_number_is_refused) {
  for (const char* text :
       {"nan", "inf", "-inf", "NAN", "0x1", "0.3rad", "0,3", "1e999", "1e-999", "--0.3", "+-0.3", "+", ".", "0.3 0.4", "''"}) {
    EXPECT_NE(complaints("[Limit obstacle]\nmax_height=" + std::string(text) + "\n"), "") << text;
    EXPECT_EQ(config_.limit.max_height, 0.2) << text;
  }
  for (const char* text : {"100.0", "1e2", "99999999999999999999", "10 0", "100,"})
    EXPECT_NE(complaints("[Floor]\niterRansac=" + std::string(text) + "\n"), "") << text;
}

TEST_F(ConfigFile, the_locale_has_no_say_in_numbers) {
  const std::string before = setlocale(LC_ALL, nullptr);
  const bool german = setlocale(LC_ALL, "de_DE.UTF-8") != nullptr;
  EXPECT_EQ(complaints("[Limit obstacle]\nmax_height=0.25\n"), "");
  EXPECT_EQ(config_.limit.max_height, 0.25);
  setlocale(LC_ALL, before.c_str());
  if (!german) GTEST_SKIP() << "no locale de_DE.UTF-8 here, only the present one was tried";
}

TEST_F(ConfigFile, an_unknown_key_names_the_nearest) {
  EXPECT_EQ(complaints("[Floor]\nitrRansac=100\n"), "t.cfg:2: no parameter 'itrRansac' in [Floor], nearest is 'iterRansac'\n");
  EXPECT_EQ(complaints("[Floor]\niterransac=100\n"), "t.cfg:2: no parameter 'iterransac' in [Floor], nearest is 'iterRansac'\n");
  EXPECT_EQ(complaints("[main]\nitrRansac=100\n"), "t.cfg:2: no parameter 'itrRansac' in [main], nearest is 'iterRansac' in [Floor]\n");
  EXPECT_EQ(complaints("[ipc]\nbroccoli=100\n"),
            "t.cfg:2: no parameter 'broccoli' in [ipc], nearest is 'group', there are memory, group\n");
  EXPECT_EQ(complaints("[image source]\nndsip=48\nwidht=64\n"),
            "t.cfg:2: no parameter 'ndsip' in [image source], nearest is 'ndisp'\n"
            "t.cfg:3: no parameter 'widht' in [image source], nearest is 'width'\n");
  EXPECT_EQ(complaints("[Map]\nrnage=5\nragne=5\nclel=1\n"),
            "t.cfg:2: no parameter 'rnage' in [Map], nearest is 'range'\n"
            "t.cfg:3: no parameter 'ragne' in [Map], nearest is 'range'\n"
            "t.cfg:4: no parameter 'clel' in [Map], nearest is 'cell'\n");
}

TEST_F(ConfigFile, a_key_in_the_wrong_section_names_its_own) {
  EXPECT_EQ(complaints("[Floor]\nndisp=48\n"), "t.cfg:2: no parameter 'ndisp' in [Floor], it belongs to [image source]\n");
  EXPECT_EQ(complaints("[Floor]\nwidth=48\n"),
            "t.cfg:2: no parameter 'width' in [Floor], it belongs to [image source] or [Map] or [census] or [decide] or [sim]\n");
  EXPECT_EQ(complaints("ndisp=48\n"), "t.cfg:1: 'ndisp' stands before the first [section], must be in [image source]\n");
}

TEST_F(ConfigFile, an_unknown_section_names_the_nearest_and_its_keys_are_judged_there) {
  EXPECT_EQ(complaints("[floor]\niterRansac=5\n"),
            "t.cfg:1: no section [floor], nearest is [Floor]\n"
            "t.cfg:2: iterRansac = 5, must be a number from 10 to 2000 [-], default 100\n");
  EXPECT_EQ(complaints("[image_source]\n"), "t.cfg:1: no section [image_source], nearest is [image source]\n");
  EXPECT_EQ(complaints("[broccoli]\nx=5\n[Floor]\niterRansac=5\n"),
            "t.cfg:1: no section [broccoli], there are [main], [image source], [camera], [mounting], [Floor], [Limit obstacle], [Map], "
            "[Memory], [census], [snow], [decide], [ipc], [control], [recorder], [drive], [sim]\n"
            "t.cfg:4: iterRansac = 5, must be a number from 10 to 2000 [-], default 100\n");
}

TEST_F(ConfigFile, the_nearest_is_counted_in_letters) {
  EXPECT_EQ(edit_distance("ndisp", "ndisp"), 0u);
  EXPECT_EQ(edit_distance("ndisp", "NDISP"), 0u);
  EXPECT_EQ(edit_distance("ndisp", "disp"), 1u);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3u);
  EXPECT_EQ(edit_distance("", "abc"), 3u);
  EXPECT_EQ(edit_distance("ndisp", "ndsip"), 1u) << "two neighbours swapped are one mistake";
  EXPECT_EQ(edit_distance("ab", "BA"), 1u);
}

TEST_F(ConfigFile, a_key_twice_is_refused_with_both_lines) {
  EXPECT_EQ(complaints("[Floor]\niterRansac=50\n[Map]\ncell=0.1\n[Floor]\niterRansac=50\n"),
            "t.cfg:6: iterRansac stands twice in [Floor], first in line 2\n");
}

TEST_F(ConfigFile, a_line_that_is_nothing_is_refused) {
  EXPECT_EQ(complaints("[Floor]\nfoo\n=4\n[Map\ncell=0.2\n[Floor] minRansac=3\n"),
            "t.cfg:2: not a [section], a key = value, or a comment\n"
            "t.cfg:3: not a [section], a key = value, or a comment\n"
            "t.cfg:4: '[Map' has no ], must be [section]\n"
            "t.cfg:6: 'minRansac=3' after [section], must be in a line of its own\n");
  EXPECT_EQ(complaints("[Floor]\nfoo"), "t.cfg:2: not a [section], a key = value, or a comment\n");
}

TEST_F(ConfigFile, all_complaints_come_at_once_and_nothing_changes) {
  config_.floor.iterRansac = 42;
  write("[Floor]\niterRansac=1\nminRansac=50\n[Map]\ncell=0\n[nowhere]\n");
  const std::vector<std::string> sets{"Floor.distThres=0", "Map.minCount=9"};
  const ConfigReading reading = read_config(file(), sets, config_);
  EXPECT_EQ(reading.complaints.size(), 4u);
  EXPECT_EQ(reading.exit_code, EX_CONFIG);
  EXPECT_EQ(config_.floor.iterRansac, 42);
  EXPECT_EQ(config_.floor.minRansac, 100);
  EXPECT_EQ(config_.map.minCount, 3);
}

TEST_F(ConfigFile, blanks_quotes_and_comments_are_as_everywhere) {
  EXPECT_EQ(complaints("\xef\xbb\xbf  [  image source ]  # where from\r\n"
                       "\tndisp\t=\t\"64\"\t; more\r\n"
                       "  corrsize='9' # less\r\n"
                       "paramfile=/a#b;c.ini\r\n"
                       "  left = \"/x #1 ;2/%d.png\"  # pattern\r\n"
                       "right = '/y #1 ;2/\"$HOME\"'\r\n"),
            "");
  EXPECT_EQ(config_.image_source.ndisp, 64);
  EXPECT_EQ(config_.image_source.corrsize, 9);
  EXPECT_EQ(config_.image_source.paramfile, "/a#b;c.ini");
  EXPECT_EQ(config_.image_source.left, "/x #1 ;2/%d.png");
  EXPECT_EQ(config_.image_source.right, "/y #1 ;2/\"$HOME\"");
}

TEST_F(ConfigFile, an_indented_line_is_a_line_of_its_own) {
  EXPECT_EQ(complaints("[Floor]\nminRansac=50\n   iterRansac=60\n   distThres=5\n"), "");
  EXPECT_EQ(config_.floor.minRansac, 50);
  EXPECT_EQ(config_.floor.iterRansac, 60);
  EXPECT_EQ(config_.floor.distThres, 5);
}

TEST_F(ConfigFile, quotes_that_do_not_close_are_refused) {
  EXPECT_EQ(complaints("[main]\nname=\"abc\n"), "t.cfg:2: name = \"abc, the closing \" is missing\n");
  EXPECT_EQ(complaints("[main]\nname='abc # d\n"), "t.cfg:2: name = 'abc # d, the closing ' is missing\n");
  EXPECT_NE(complaints("[main]\nname=\"abc\" d\n").find("'d' after the closing quote"), std::string::npos)
      << "found: " << complaints("[main]\nname=\"abc\" d\n");
}

TEST_F(ConfigFile, paths_take_the_environment_and_other_texts_do_not) {
  setenv("VDISP_TEST_PLACE", "/data/pairs", 1);
  EXPECT_EQ(complaints("[image source]\nsource=files\nleft=\"$VDISP_TEST_PLACE/l.avi\"\nright=${VDISP_TEST_PLACE}2/r.avi\n"
                       "paramfile=\"/a\\$b.ini\"\n[main]\nname=$VDISP_TEST_PLACE\n"),
            "");
  EXPECT_EQ(config_.image_source.left, "/data/pairs/l.avi");
  EXPECT_EQ(config_.image_source.right, "/data/pairs2/r.avi");
  EXPECT_EQ(config_.image_source.paramfile, "/a$b.ini");
  EXPECT_EQ(config_.main.name, "$VDISP_TEST_PLACE");
  unsetenv("VDISP_TEST_PLACE");
  EXPECT_EQ(complaints("[image source]\nparamfile=$VDISP_TEST_PLACE/c.ini\n"),
            "t.cfg:2: paramfile = $VDISP_TEST_PLACE/c.ini, $VDISP_TEST_PLACE is not in the environment; a plain $ is written "
            "\"\\$\"\n");
  EXPECT_NE(complaints("[image source]\nparamfile=/a$\n"), "");
  EXPECT_NE(complaints("[image source]\nparamfile=${HOME\n"), "");
}

TEST_F(ConfigFile, relative_paths_begin_at_the_file_and_those_of_options_at_the_working_folder) {
  EXPECT_EQ(complaints("[image source]\nparamfile=cal/c.ini\nleft=l/%d.png\n", {"image source.left=m/%d.png"}), "");
  EXPECT_EQ(config_.image_source.paramfile, (folder_ / "cal/c.ini").string());
  EXPECT_EQ(config_.image_source.left, (fs::current_path() / "m/%d.png").string());
}

TEST_F(ConfigFile, options_go_before_the_file_and_the_last_one_holds) {
  EXPECT_EQ(complaints("[image source]\nndisp=32\n",
                       {"image source.ndisp=64", "image_source.ndisp = 96", "Limit_obstacle.max_height=0.3", "main.name='a=b'"}),
            "");
  EXPECT_EQ(config_.image_source.ndisp, 96);
  EXPECT_EQ(config_.limit.max_height, 0.3);
  EXPECT_EQ(config_.main.name, "a=b");
}

TEST_F(ConfigFile, a_wrong_option_is_refused_with_its_text) {
  const std::string what = " must be SECTION.KEY=VALUE, such as \"image source.ndisp=64\"\n";
  EXPECT_EQ(complaints("", {"ndisp=64"}), "--set ndisp=64:" + what);
  EXPECT_EQ(complaints("", {"Floor.iterRansac"}), "--set Floor.iterRansac:" + what);
  EXPECT_EQ(complaints("", {""}), "--set :" + what);
  EXPECT_EQ(complaints("", {"Floor.iterRansac=9999"}),
            "--set Floor.iterRansac=9999: iterRansac = 9999, must be a number from 10 to 2000 [-], default 100\n");
  EXPECT_EQ(complaints("", {"Flor.iterRansac=100"}), "--set Flor.iterRansac=100: no section [Flor], nearest is [Floor]\n");
  EXPECT_EQ(complaints("", {"Floor.itrRansac=100"}),
            "--set Floor.itrRansac=100: no parameter 'itrRansac' in [Floor], nearest is 'iterRansac'\n");
  EXPECT_NE(complaints("", {"main.name=a\nb"}), "");
}

TEST_F(ConfigFile, angRot_in_one_section_holds_for_both) {
  for (const char* section : {"[Map]\n", "[Limit obstacle]\n"}) {
    EXPECT_EQ(complaints(std::string(section) + "angRot=0.4\n"), "");
    EXPECT_EQ(config_.limit.angRot, 0.4);
    EXPECT_EQ(config_.map.angRot, 0.4);
    EXPECT_EQ(complaints(std::string(section) + "angRot=auto\n"), "");
    EXPECT_TRUE(config_.automatic_pitch());
    EXPECT_TRUE(std::isnan(config_.map.angRot));
  }
  EXPECT_EQ(complaints("[Map]\nangRot=0.3\n[Limit obstacle]\nangRot=0.3\n", {"Map.angRot=auto"}), "");
  EXPECT_TRUE(config_.automatic_pitch());
}

TEST_F(ConfigFile, angRot_twice_must_be_the_same) {
  EXPECT_EQ(complaints("[Map]\nangRot=0.3\n[Limit obstacle]\nangRot=0.30\n"), "");
  EXPECT_EQ(complaints("[Map]\nangRot=auto\n[Limit obstacle]\nangRot=auto\n"), "");
  EXPECT_EQ(complaints("[Map]\nangRot=0.3\n[Limit obstacle]\nangRot=0.26\n"),
            "t.cfg:4: angRot = 0.26 in [Limit obstacle] but 0.3 in [Map] (line 2), must be the same in both, or in one of them only\n");
  EXPECT_EQ(complaints("[Limit obstacle]\nangRot=auto\n[Map]\nangRot=0.26\n"),
            "t.cfg:4: angRot = 0.26 in [Map] but auto in [Limit obstacle] (line 2), must be the same in both, or in one of them "
            "only\n");
  EXPECT_NE(complaints("", {"Map.angRot=0.1", "Limit obstacle.angRot=0.2"}), "");
}

TEST_F(ConfigFile, contradictions_are_refused_where_the_last_of_their_values_stands) {
  EXPECT_EQ(complaints("[Floor]\nanglefloorMax=0.5\nanglefloorMin=0.5\n"),
            "t.cfg:3: anglefloorMin = 0.5, must be less than anglefloorMax = 0.5\n");
  EXPECT_EQ(complaints("[Floor]\nanglefloorMin=0.95\n"), "t.cfg:2: anglefloorMin = 0.95, must be less than anglefloorMax = 0.9\n");
  EXPECT_EQ(complaints("[Floor]\nanglefloorMin=0.95\n", {"Floor.anglefloorMax=0.9"}),
            "--set Floor.anglefloorMax=0.9: anglefloorMin = 0.95, must be less than anglefloorMax = 0.9\n");
  EXPECT_EQ(complaints("[Map]\nrange=200\ncell=0.01\n"),
            "t.cfg:3: range = 200 m with cell = 0.01 m makes 20000 cells, must be from 1 to 4096\n");
  EXPECT_EQ(complaints("[Map]\nwidth=0.5\ncell=2\n"), "t.cfg:3: width = 0.5 m with cell = 2 m makes 0 cells, must be from 1 to 4096\n");
  EXPECT_EQ(complaints("[image source]\nright=/r.avi\n"), "t.cfg:2: right = /r.avi without left, must have the left images too\n");
  EXPECT_EQ(complaints("[image source]\nsource=files\n"),
            "t.cfg:2: source = files without left, must have left = a pattern, a glob or a video, or recording = a folder\n");
  EXPECT_NE(complaints("[image source]\nsource=files\nleft=/a.avi\nright=/a.avi\n"), "");
  EXPECT_EQ(complaints("[image source]\nwidth=160\nndisp=128\nminDisparity=32\n"),
            "t.cfg:4: ndisp = 128 with minDisparity = 32 and corrsize = 11 needs 171 columns, must fit width = 160\n");
  EXPECT_EQ(complaints("[image source]\nsource=sim\nwidth=320\n"),
            "t.cfg:3: width = 320, must be 0 or the size of the simulated images: [sim] width = 640\n");
  EXPECT_EQ(complaints("[image source]\nsource=sim\nbayer=rggb\n"),
            "t.cfg:3: bayer = rggb with source = sim, must be none: its images are grey\n");
  EXPECT_NE(complaints("[image source]\nheight=8\n"), "");
  EXPECT_NE(complaints("[main]\nname=\"\"\n"), "");
  EXPECT_EQ(complaints("[main]\nname=a,b\n"), "t.cfg:2: name = a,b, must be without commas, blanks and control characters\n");
  EXPECT_NE(complaints("[main]\nname=\"a b\"\n"), "");
  EXPECT_NE(complaints("", {"main.name=a\tb"}), "");
  EXPECT_EQ(complaints("[image source]\nndisp=16\nminDisparity=-128\n"),
            "t.cfg:3: ndisp = 16 with minDisparity = -128 searches beyond infinity alone, must end above 0\n");
  EXPECT_NE(complaints("[image source]\nndisp=16\nminDisparity=-16\n"), "");
  EXPECT_EQ(complaints("[image source]\nndisp=16\nminDisparity=-15\n"), "");
  EXPECT_NE(complaints("[main]\nname=" + std::string(101, 'a') + "\n"), "");
  EXPECT_EQ(complaints("[main]\nname=" + std::string(100, 'a') + "\n"), "");
}

TEST_F(ConfigFile, detectors_are_a_list_and_blanks_around_its_comma_do_not_matter) {
  for (const char* list : {"vdisparity, snow", "vdisparity,snow", "vdisparity ,  snow", "snow,vdisparity"}) {
    EXPECT_EQ(complaints("[main]\ndetectors = " + std::string(list) + "\n[snow]\nmodel = m\n"), "") << list;
    EXPECT_TRUE(config_.detects("vdisparity") && config_.detects("snow")) << list;
    EXPECT_EQ(config_.main.detectors.size(), 16u) << "as --print-config writes it";
  }
  EXPECT_EQ(complaints("[main]\ndetectors = snow\n[snow]\nmodel = m\n"), "");
  EXPECT_TRUE(config_.detects("snow") && !config_.detects("vdisparity") && !config_.detects("now"));
  EXPECT_NE(complaints("[main]\ndetectors = snow snow\n"), "");
  EXPECT_NE(complaints("[main]\ndetectors = snow\n").find("without [snow] model"), std::string::npos);
  EXPECT_NE(complaints("[decide]\nleastSpeed = 0.6\n").find("must be at most speed = 0.5"), std::string::npos);
  EXPECT_NE(complaints("[decide]\nnear = 3\n").find("must be less than far = 2.5"), std::string::npos);
}

TEST_F(ConfigFile, a_contradiction_of_a_value_that_is_refused_anyway_is_not_told_twice) {
  EXPECT_EQ(complaints("[Floor]\nanglefloorMax=9\nanglefloorMin=0.95\n"),
            "t.cfg:2: anglefloorMax = 9, must be a number from 0 to 1.55 [rad], default 0.9\n");
}

TEST_F(ConfigFile, left_without_source_files_is_noted) {
  const ConfigReading reading = read("[image source]\nleft=/l.avi\n");
  EXPECT_EQ(reading.exit_code, 0);
  ASSERT_EQ(reading.notes.size(), 1u);
  EXPECT_EQ(reading.notes[0].line, 2);
}

TEST_F(ConfigFile, a_long_path_is_read_whole_and_a_line_without_end_refused) {
  const std::string path = "/" + std::string(3000, 'p') + "/c.ini";
  EXPECT_EQ(complaints("[image source]\nparamfile = " + path + "\n"), "");
  EXPECT_EQ(config_.image_source.paramfile, path);
  EXPECT_EQ(complaints("[image source]\n" + std::string(8193, ' ') + "\nndisp=5\n"),
            "t.cfg:2: line of 8193 characters, must have at most 8192\n"
            "t.cfg:3: ndisp = 5, must be a number from 16 to 256 in steps of 16 [pixel], default 48\n");
  EXPECT_EQ(complaints("#" + std::string(8191, 'x') + "\n"), "");
  EXPECT_NE(complaints("[main]\n" + std::string(8190, 'k') + "=1\n"), "");
  EXPECT_NE(complaints("[" + std::string(8190, 's') + "]\n"), "");
  EXPECT_NE(complaints("[main]\nname=" + std::string(5000, 'n') + "\n"), "");
}

TEST_F(ConfigFile, what_is_no_text_is_refused_once) {
  EXPECT_EQ(complaints(std::string("[main]\nna\0me=1\nfoo\nbar\n", 22)),
            "t.cfg:2: byte 0x00 at column 3, must be text; the rest of the file was not read\n");
  EXPECT_EQ(complaints("\x89PNG\r\n\x1a\n"),
            "t.cfg:1: not a [section], a key = value, or a comment\n"
            "t.cfg:2: byte 0x1a at column 1, must be text; the rest of the file was not read\n");
  EXPECT_EQ(complaints(std::string((1 << 20) + 1, '\n')), "t.cfg: has more than 1 MiB, must be a vdisp.cfg\n");
}

TEST_F(ConfigFile, rubbish_never_crashes_and_never_gives_more_than_a_page_of_complaints) {
  std::mt19937 random(1);
  const std::string letters = "[]=\"'\\#;$ {}\n\r\tFloor.main:0123456789-+e\xef\xbb\xbf\xff";
  for (int round = 0; round < 300; ++round) {
    std::string text(random() % 3000, ' ');
    for (char& c : text) c = round % 3 == 0 ? static_cast<char>(random()) : letters[random() % letters.size()];
    const ConfigReading reading = read(text, {text.substr(0, 100)});
    EXPECT_LE(reading.complaints.size(), 101u);  // the last one says that there are more
    if (!reading.complaints.empty()) {
      EXPECT_EQ(printed(config_), printed(Config{}));
    }
  }
  std::string many;
  for (int i = 0; i < 1000; ++i) many += "foo\n";
  EXPECT_EQ(read(many).complaints.size(), 101u);
}

TEST_F(ConfigFile, a_file_that_cannot_be_read_says_why) {
  ConfigReading reading = read_config(folder_ / "none.cfg", {}, config_);
  EXPECT_EQ(said(reading), "none.cfg: cannot be read: No such file or directory; must be a vdisp.cfg\n");
  EXPECT_EQ(reading.exit_code, EX_NOINPUT);
  reading = read_config(folder_, {}, config_);
  ASSERT_EQ(reading.complaints.size(), 1u);
  EXPECT_EQ(reading.complaints[0].text, "cannot be read: Is a directory; must be a vdisp.cfg");
  EXPECT_EQ(reading.exit_code, EX_NOINPUT);
}

TEST_F(ConfigFile, a_file_without_permission_says_so) {
  write("[main]\n");
  chmod(file().c_str(), 0);
  chmod(folder_.c_str(), 0755);
  const bool root = geteuid() == 0;
  if (root && seteuid(65534) != 0) GTEST_SKIP() << "root that cannot become nobody";
  const ConfigReading reading = read_config(file(), {}, config_);
  if (root) {
    ASSERT_EQ(seteuid(0), 0);
  }
  EXPECT_EQ(said(reading), "t.cfg: cannot be read: Permission denied; must be a vdisp.cfg\n");
  EXPECT_EQ(reading.exit_code, EX_NOPERM);
}

}  // namespace
}  // namespace vdisp
