// config_file_test.cpp: whose a vdisp.cfg is after it was written anew.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/control/config_file.h"

#include <grp.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>

#include "tests/support/temporary_folder.h"

namespace vdisp {
namespace {

constexpr uid_t rover = 64321;  // no group of its own but this
constexpr gid_t team = 64322;   // the rover's user is no member

/// The mode and group after a user without rights wrote the file anew, in a folder of its own.
struct stat rewritten_by_rover(mode_t mode, gid_t group) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder / "vdisp.cfg";
  std::string text = "[Map]\nminCount = 5\n";
  std::ofstream(file) << text;
  EXPECT_EQ(chown(file.c_str(), rover, group), 0);
  EXPECT_EQ(chmod(file.c_str(), mode), 0);
  EXPECT_EQ(chown(file.parent_path().c_str(), rover, rover), 0);
  const pid_t child = fork();
  if (child == 0) {
    const bool became = setgroups(0, nullptr) == 0 && setgid(rover) == 0 && setuid(rover) == 0;
    _exit(became && replace_config(file, text, "[Map]\nminCount = 7\n").empty() ? 0 : 1);
  }
  int status = 0;
  EXPECT_EQ(waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0) << "it was written";
  struct stat found {};
  EXPECT_EQ(stat(file.c_str(), &found), 0);
  return found;
}

TEST(ConfigFile, keeps_its_group_and_mode_where_the_group_is_the_writers) {
  if (geteuid() != 0) GTEST_SKIP() << "only root may become another user";
  const struct stat found = rewritten_by_rover(0664, rover);
  EXPECT_EQ(found.st_mode & 07777, 0664u);
  EXPECT_EQ(found.st_gid, rover);
}

TEST(ConfigFile, of_a_group_that_cannot_be_kept_is_not_opened_to_the_writers_group) {
  if (geteuid() != 0) GTEST_SKIP() << "only root may become another user";
  const struct stat found = rewritten_by_rover(0664, team);
  EXPECT_EQ(found.st_gid, rover);
  EXPECT_EQ(found.st_mode & 07777, 0604u) << "what the team might do was not meant for this group";
}

}  // namespace
}  // namespace vdisp
