// replies.h: what the controller answers: whether it can be believed to hear.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <regex.h>

#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>

namespace vdisp::drive {

enum class Hearing {
  not_asked,  ///< no pattern is configured
  good,       ///< it answers as it should
  silent,     ///< no answer, for longer than replyTimeout or since the port was opened
  rubbish,    ///< answers, but not what the pattern says
};

/// Lines end with \r or \n; empty ones do not count. Times are CLOCK_MONOTONIC, ns.
class Replies {
 public:
  /// `pattern`: extended regular expression (POSIX) that a whole line must match; empty: nothing is expected. Throws
  /// std::invalid_argument with what is wrong with it.
  Replies(const std::string& pattern, int64_t timeout_ns);

  void take(std::string_view bytes, int64_t now_ns);
  /// The port was opened: nobody has answered yet.
  void forget(int64_t now_ns);
  /// Bad at once after three wrong lines in a row, or without a right one for the timeout; good again after three right ones in a row.
  Hearing judge(int64_t now_ns);
  /// The last wrong line, for people.
  const std::string& wrong() const { return wrong_; }
  uint64_t right_lines() const { return right_lines_; }
  uint64_t wrong_lines() const { return wrong_lines_; }

 private:
  void line(int64_t now_ns);

  struct Free {
    void operator()(regex_t* pattern) const {
      regfree(pattern);
      delete pattern;
    }
  };
  std::unique_ptr<regex_t, Free> pattern_;
  int64_t timeout_ns_, right_ns_ = 0;
  std::string line_, wrong_;
  bool overlong_ = false, good_ = false, wrong_since_right_ = false;
  int right_row_ = 0, wrong_row_ = 0;
  uint64_t right_lines_ = 0, wrong_lines_ = 0;
};

}  // namespace vdisp::drive
