// replies.cpp: cuts what comes into lines and compares them with the pattern.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/tools/drive/replies.h"

#include "daemon/tools/drive/phrase.h"

namespace vdisp::drive {
namespace {

constexpr size_t longest_line = 128;
constexpr int enough = 3;  // a single wrong line is noise on the wire, or the rest of what was said before the port was opened

}  // namespace

Replies::Replies(const std::string& pattern, int64_t timeout_ns) : timeout_ns_(timeout_ns) {
  line_.reserve(longest_line);
  if (pattern.empty()) return;
  auto made = std::make_unique<regex_t>();
  const int error = regcomp(made.get(), ("^(" + pattern + ")$").c_str(), REG_EXTENDED | REG_NOSUB);
  if (error != 0) {
    char text[128];
    regerror(error, made.get(), text, sizeof text);
    throw std::invalid_argument(std::string(text) + "; must be an extended regular expression of a whole line, as \\+ or OK");
  }
  pattern_.reset(made.release());
}

void Replies::forget(int64_t now_ns) {
  line_.clear();
  overlong_ = good_ = wrong_since_right_ = false;
  right_row_ = wrong_row_ = 0;
  right_ns_ = now_ns;
}

void Replies::line(int64_t now_ns) {
  if (!overlong_ && regexec(pattern_.get(), line_.c_str(), 0, nullptr, 0) == 0) {
    ++right_lines_;
    ++right_row_;
    wrong_row_ = 0;
    wrong_since_right_ = false;
    right_ns_ = now_ns;
    return;
  }
  ++wrong_lines_;
  ++wrong_row_;
  right_row_ = 0;
  wrong_since_right_ = true;
  wrong_ = escaped(line_.substr(0, 40)) + (overlong_ || line_.size() > 40 ? "..." : "");
}

void Replies::take(std::string_view bytes, int64_t now_ns) {
  if (!pattern_) return;
  for (const char c : bytes) {
    if (c == '\r' || c == '\n') {
      if (!line_.empty()) line(now_ns);
      line_.clear();
      overlong_ = false;
    } else if (line_.size() < longest_line) {
      line_ += c == '\0' ? '?' : c;  // the pattern is matched as a C string
    } else {
      // Rubbish need not have line ends: what is longer than any reply counts at once.
      overlong_ = true;
      line(now_ns);
      line_.assign(1, c);
    }
  }
}

Hearing Replies::judge(int64_t now_ns) {
  if (!pattern_) return Hearing::not_asked;
  const bool late = now_ns - right_ns_ > timeout_ns_;
  if (good_ && (late || wrong_row_ >= enough)) {
    good_ = false;
    right_row_ = 0;
  }
  if (!good_ && !late && right_row_ >= enough) good_ = true;
  if (good_) return Hearing::good;
  return wrong_since_right_ ? Hearing::rubbish : Hearing::silent;
}

}  // namespace vdisp::drive
