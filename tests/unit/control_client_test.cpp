// control_client_test.cpp: the client's end of the control socket keeps its time limit, whatever the daemon does.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "ipc/include/vdisp/control.h"
#include "tests/support/standin_control.h"
#include "tests/support/temporary_folder.h"

namespace vdisp {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

constexpr uint32_t keys = 100;

/// Answers what it has heard every so often, as a daemon does between two frames.
class SlowDaemon {
 public:
  SlowDaemon(const std::string& path, milliseconds pause)
      : socket_(path), thread_([this, pause] {
          while (!ending_) {
            std::this_thread::sleep_for(pause);
            for (const auto& heard : socket_.hear()) {
              ParameterMessage question;
              std::memcpy(&question, heard.bytes.data(), sizeof question);
              ReplyMessage reply{};
              reply.index = question.index;
              reply.count = keys;
              ("Section.key" + std::to_string(question.index)).copy(reply.key, sizeof reply.key - 1);
              socket_.answer(heard, reply);
            }
          }
        }) {}
  ~SlowDaemon() {
    ending_ = true;
    thread_.join();
  }

 private:
  StandInControl socket_;
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

struct ControlClientTest : testing::Test {
  TemporaryFolder folder;
  std::string path = (folder / "control").string();
};

TEST_F(ControlClientTest, all_parameters_come_in_their_order) {
  SlowDaemon daemon(path, milliseconds(5));
  Control control(path);
  std::vector<ParameterInfo> all;
  ASSERT_EQ(control.get_all(all), Control::Result::done) << control.message();
  ASSERT_EQ(all.size(), keys);
  for (uint32_t i = 0; i < keys; ++i) EXPECT_EQ(all[i].key, "Section.key" + std::to_string(i));
}

TEST_F(ControlClientTest, the_limit_is_that_of_the_whole_call_however_many_answers_it_takes) {
  SlowDaemon daemon(path, milliseconds(150));
  Control control(path, milliseconds(300));
  std::vector<ParameterInfo> all;
  const auto start = Clock::now();
  EXPECT_EQ(control.get_all(all), Control::Result::no_answer);
  EXPECT_LT(Clock::now() - start, milliseconds(450));
  EXPECT_NE(control.message().find("within 300 ms"), std::string::npos) << control.message();
}

}  // namespace
}  // namespace vdisp
