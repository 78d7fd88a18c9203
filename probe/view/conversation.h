// conversation.h: the control socket in a thread of its own: who asks goes on at once, and hears the answer later.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "ipc/include/vdisp/control.h"

namespace vdisp {

struct Wish {
  enum class Kind { all, set, undo, save } kind;
  std::string key, value;  ///< set
  bool joined = false;     ///< set: one step for undo with the one before
};

struct WishAnswer {
  Wish wish;
  Control::Result result;
  std::string message;             ///< why not; of save: where
  ParameterInfo info;              ///< of set and undo, where they were done
  std::vector<ParameterInfo> all;  ///< of all
};

/// One wish is under way at a time, in their order. Of a slider that moves faster than the daemon answers only the newest value is asked
/// for.
class Conversation {
 public:
  Conversation(const std::string& control, std::chrono::milliseconds limit);
  /// Waits for what is under way, `limit` at most; what waits is given up.
  ~Conversation();
  Conversation(const Conversation&) = delete;
  Conversation& operator=(const Conversation&) = delete;

  /// Does not wait. False: it took the place of the one before, which still waited to set the same key, and there is one answer for both.
  bool ask(Wish wish);
  /// The next answer that has come. Does not wait.
  std::optional<WishAnswer> hear();

 private:
  void run();
  WishAnswer talk(const Wish& wish);

  Control control_;  // the thread's
  std::mutex mutex_;
  std::condition_variable woken_;
  std::deque<Wish> wishes_;
  std::deque<WishAnswer> answers_;
  bool ending_ = false;
  std::thread thread_;
};

}  // namespace vdisp
