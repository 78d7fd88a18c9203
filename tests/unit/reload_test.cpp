// reload_test.cpp: what another reading of vdisp.cfg takes, and keeps; when a file counts as changed; what is one step for undo.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/control/reload.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <thread>

#include "daemon/control/live_parameters.h"
#include "tests/support/temporary_folder.h"

namespace vdisp {
namespace {

namespace fs = std::filesystem;
using Rows = std::vector<const Parameter*>;

const Parameter* thresh = find_parameter("image source.thresh");
const Parameter* unique = find_parameter("image source.unique");

TEST(MergeTest, the_files_values_are_taken_and_what_needs_a_restart_is_named_and_left) {
  Config before, now, running;
  now.image_source.thresh = 20;
  now.image_source.ndisp = 64;
  now.map.cell = 0.2;
  const Reload reload = merge(before, now, running, Precedence::file);
  EXPECT_EQ(reload.taken, Rows{thresh});
  EXPECT_EQ(reload.restart, (Rows{find_parameter("image source.ndisp"), find_parameter("Map.cell")}));
  EXPECT_EQ(running.image_source.thresh, 20);
  EXPECT_EQ(running.image_source.ndisp, 48);
}

TEST(MergeTest, what_was_set_by_hand_is_given_up_for_the_file_or_kept_where_the_file_says_what_it_said) {
  Config before, now;
  now.image_source.unique = 5;
  for (const Precedence precedence : {Precedence::file, Precedence::hand}) {
    Config running;
    running.image_source.thresh = 33;  // by hand; the file says 10 as ever
    running.image_source.unique = 7;   // by hand; the file says something else now
    const Reload reload = merge(before, now, running, precedence);
    EXPECT_EQ(running.image_source.unique, 5);
    EXPECT_EQ(running.image_source.thresh, precedence == Precedence::file ? 10 : 33);
    EXPECT_EQ(reload.taken, precedence == Precedence::file ? (Rows{thresh, unique}) : Rows{unique});
    EXPECT_EQ(reload.kept, precedence == Precedence::file ? Rows{} : Rows{thresh});
  }
}

TEST(MergeTest, what_contradicts_a_value_set_by_hand_changes_nothing) {
  Config before, now, running;
  running.floor.anglefloorMin = 0.6;  // by hand
  now.floor.anglefloorMax = 0.5;
  const Reload reload = merge(before, now, running, Precedence::hand);
  EXPECT_NE(reload.fault.find("anglefloorMin"), std::string::npos) << reload.fault;
  EXPECT_EQ(running.floor.anglefloorMax, Config{}.floor.anglefloorMax);
}

TEST(MergeTest, angRot_is_one_value) {
  Config before, now, running;
  now.limit.angRot = now.map.angRot = 0.4;
  EXPECT_EQ(merge(before, now, running, Precedence::file).taken.size(), 1u);
  EXPECT_EQ(running.map.angRot, 0.4);
}

using Event = ConfigWatch::Event;

struct ConfigWatchTest : testing::Test {
  TemporaryFolder folder;
  fs::path file = folder.write("vdisp.cfg", "[Map]\n");
};

TEST_F(ConfigWatchTest, a_written_a_renamed_and_a_linked_file_are_changes_and_their_neighbours_are_none) {
  ConfigWatch watch(file, true);
  EXPECT_EQ(watch.trouble(), "");
  folder.write("vdisp.cfg~", "other");
  EXPECT_EQ(watch.wait(400), Event::nothing);
  folder.write("vdisp.cfg", "[Map]\nminCount = 4\n");
  EXPECT_EQ(watch.wait(3000), Event::changed);
  EXPECT_EQ(watch.wait(400), Event::nothing) << "told once";
  fs::rename(folder.write("vdisp.cfg.new", "[Map]\nminCount = 5\n"), file);
  EXPECT_EQ(watch.wait(3000), Event::changed);
  fs::rename(file, folder / "vdisp.cfg~");  // vim with backupcopy=no
  folder.write("vdisp.cfg", "[Map]\nminCount = 6\n");
  EXPECT_EQ(watch.wait(3000), Event::changed);
  EXPECT_EQ(watch.wait(400), Event::nothing);
  fs::remove(file);
  fs::create_symlink(folder.write("real/there.cfg", "[Map]\n"), file);
  EXPECT_EQ(watch.wait(3000), Event::changed);
  folder.write("real/there.cfg", "[Map]\nminCount = 7\n");
  EXPECT_EQ(watch.wait(3000), Event::changed) << "what the link leads to";
}

TEST_F(ConfigWatchTest, writing_again_and_again_is_one_change_and_a_writer_that_never_rests_is_looked_at) {
  ConfigWatch watch(file, true);
  int told = 0;
  std::atomic<bool> ending{false};
  std::thread writer([&] {
    for (int i = 0; i < 25 && !ending; ++i) {
      folder.write("vdisp.cfg", std::to_string(i));
      std::this_thread::sleep_for(std::chrono::milliseconds(60));
    }
  });
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(watch.wait(5000), Event::changed);
  EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), 1.5);
  while (watch.wait(700) == Event::changed) ++told;
  ending = true;
  writer.join();
  EXPECT_LE(told, 3);
}

TEST_F(ConfigWatchTest, a_folder_that_goes_and_comes_back_is_watched_again) {
  const fs::path inner = folder.write("etc/vdisp.cfg", "[Map]\n");
  ConfigWatch watch(inner, true);
  fs::remove_all(folder / "etc");
  while (watch.wait(600) == Event::changed) {
  }
  folder.write("etc/vdisp.cfg", "[Map]\nminCount = 9\n");
  EXPECT_EQ(watch.wait(4000), Event::changed);
  while (watch.wait(600) == Event::changed) {
  }
  folder.write("etc/vdisp.cfg", "[Map]\nminCount = 8\n");
  EXPECT_EQ(watch.wait(3000), Event::changed);
}

TEST_F(ConfigWatchTest, asking_ends_the_wait_and_a_file_that_is_not_watched_does_not) {
  ConfigWatch watch(file, false);
  folder.write("vdisp.cfg", "x");
  EXPECT_EQ(watch.wait(400), Event::nothing);
  std::thread asker([&] { watch.ask(); });
  EXPECT_EQ(watch.wait(3000), Event::asked);
  asker.join();
}

struct LiveParametersTest : testing::Test {
  TemporaryFolder folder;
  fs::path file = folder.write("vdisp.cfg", "[Map]\nminCount = 5\n");
  Config config;
  std::mutex mutex;
  std::vector<std::string> lines;
  std::optional<LiveParameters> live;

  void start() {
    ASSERT_TRUE(read_config(file, {}, config).complaints.empty());
    live.emplace(config, ConfigOrigin{file, {}, true}, [this](std::string_view line, bool) {
      const std::lock_guard lock(mutex);
      lines.emplace_back(line);
    });
  }
  ReplyMessage ask(CommandType type, const char* key = "", const char* value = "", bool joined = false, uint64_t connection = 1) {
    ParameterMessage message{};
    message.header.type = type;
    std::snprintf(message.key, sizeof message.key, "%s", key);
    std::snprintf(message.value, sizeof message.value, "%s", value);
    message.joined = joined;
    EXPECT_TRUE(live->ask(message, {connection, 12, 34}));
    return next();
  }
  /// What the loop does between two frames, until there is an answer.
  ReplyMessage next() {
    LiveParameters::Reply reply;
    for (int i = 0; i < 4000; ++i) {
      if (live->next(reply)) {
        const ReplyMessage message = *reply.message;
        live->done();
        return message;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    ADD_FAILURE() << "no answer";
    return {};
  }
  bool told(const std::string& words) {
    const std::lock_guard lock(mutex);
    for (const std::string& line : lines)
      if (line.find(words) != line.npos) return true;
    return false;
  }
};

TEST_F(LiveParametersTest, a_slider_that_moves_is_one_step_for_undo_and_one_line_when_it_rests) {
  start();
  ask(CommandType::set, "thresh", "11");
  for (const char* value : {"12", "13", "14", "15"}) ask(CommandType::set, "thresh", value, true);
  EXPECT_EQ(config.image_source.thresh, 15);
  EXPECT_TRUE(told("image source.thresh: 10 -> 11 (control socket, by process 12 of user 34)"));
  EXPECT_FALSE(
      told("12"
           " -> "));
  ask(CommandType::set, "thresh", "16", true, 2);
  EXPECT_TRUE(told("image source.thresh: 11 -> 15"));
  ask(CommandType::undo);
  EXPECT_EQ(config.image_source.thresh, 15) << "another connection's was a step of its own";
  ask(CommandType::undo);
  EXPECT_EQ(config.image_source.thresh, 10);
  EXPECT_EQ(ask(CommandType::undo).answer, Answer::refused);
}

TEST_F(LiveParametersTest, a_changed_file_takes_effect_as_a_whole_and_undo_takes_it_back_as_a_whole) {
  start();
  folder.write("vdisp.cfg", "[Map]\nminCount = 8\n[image source]\nthresh = 20\nndisp = 64\n");
  next();
  EXPECT_EQ(config.map.minCount, 8);
  EXPECT_EQ(config.image_source.thresh, 20);
  EXPECT_EQ(config.image_source.ndisp, 48);
  EXPECT_EQ(live->generation(), 1u);
  EXPECT_EQ(live->reloads(), 1u);
  EXPECT_TRUE(told("parameter Map.minCount: 5 -> 8 ("));
  EXPECT_TRUE(told("image source.ndisp = 64 (now 48) needs a restart"));
  ask(CommandType::undo);
  EXPECT_EQ(config.map.minCount, 5);
  EXPECT_EQ(config.image_source.thresh, 10);
}

TEST_F(LiveParametersTest, save_takes_what_another_hand_wrote_and_is_no_change_itself) {
  start();
  ask(CommandType::set, "thresh", "11");
  folder.write("vdisp.cfg", "# another hand\n[Map]\nminCount = 6\n");
  const ReplyMessage saved = ask(CommandType::save);
  EXPECT_EQ(saved.answer, Answer::done) << saved.text;
  std::ifstream stream(file);
  const std::string text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  EXPECT_EQ(text, "# another hand\n[Map]\nminCount = 6\n\n[image source]\nthresh = 11\n");
  EXPECT_EQ(config.map.minCount, 6);
  const uint64_t before = live->reloads();
  std::this_thread::sleep_for(std::chrono::milliseconds(600));
  EXPECT_EQ(live->reloads(), before) << "its own save is not read again";
}

TEST_F(LiveParametersTest, a_file_with_faults_changes_nothing_says_each_and_is_not_saved_over) {
  start();
  ask(CommandType::set, "thresh", "11");
  const std::string wrong = "[Map]\nminCount = 9\nminCont = 3\n[image source]\nunique = 99\n";
  folder.write("vdisp.cfg", wrong);
  next();
  EXPECT_EQ(config.map.minCount, 5);
  EXPECT_EQ(live->reloads_refused(), 1u);
  EXPECT_TRUE(told("vdisp.cfg:3: "));
  EXPECT_TRUE(told("vdisp.cfg:5: unique = 99"));
  EXPECT_TRUE(told("has 2 faults: nothing was changed"));
  EXPECT_EQ(ask(CommandType::save).answer, Answer::failed);
  std::ifstream stream(file);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()), wrong);
}

}  // namespace
}  // namespace vdisp
