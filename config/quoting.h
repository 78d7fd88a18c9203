// quoting.h: how a value is written in a line of vdisp.cfg: quotes, escapes, comments, $NAME.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace vdisp {

/// What stands between key and value: either, as in every ini file.
inline constexpr std::string_view separators = "=:";
/// Some editors begin a file with it.
inline constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";

inline bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }
inline bool is_control(char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }

std::string_view trimmed(std::string_view text);
/// The line without its comment: from a # or ; that begins the line or follows a blank, and is not in quotes.
std::string_view without_comment(std::string_view line);

struct Unquoted {
  std::string text;
  std::string error;  ///< empty, or what is wrong and what would be right
};
/// "..." knows \" \\ \$; '...' is taken as it is. With `references`, $NAME and ${NAME} are taken from the environment except in
/// '...'.
Unquoted unquoted(std::string_view raw, bool references);
/// In double quotes, so that unquoted() gives it back.
std::string in_quotes(std::string_view text);
/// For a message: no control characters, and not longer than a line.
std::string printable(std::string_view text);

}  // namespace vdisp
