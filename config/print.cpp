// print.cpp: a Config as a vdisp.cfg that explains itself.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <ostream>

#include "config/parameters.h"
#include "config/quoting.h"

namespace vdisp {
namespace {

/// A comment of as many lines as it takes.
void comment(std::ostream& out, std::string_view text) {
  constexpr size_t columns = 108;
  while (!text.empty()) {
    size_t end = text.size();
    if (end > columns) {
      end = text.rfind(' ', columns);
      if (end == text.npos) end = std::min(text.find(' '), text.size());
    }
    out << "# " << text.substr(0, end) << '\n';
    text.remove_prefix(std::min(end + 1, text.size()));
  }
}

void print(std::ostream& out, const Parameter& row, const Config& config) {
  const std::string value = row.get(config);
  std::string allowed = row.allowed() + ", default " + row.default_text();
  allowed += row.when == When::live ? ", live" : ", restart";
  if (value != row.get(Config{})) allowed += ", changed here";
  out << '\n';
  comment(out, row.help);
  comment(out, allowed);
  const bool text = row.kind == Kind::text || row.kind == Kind::path;
  out << row.key << " = " << (text ? in_quotes(value) : value) << '\n';
}

}  // namespace

void print_config(std::ostream& out, const Config& config) {
  comment(out,
          "vdisp.cfg: the parameters of vdispd, and of vdisp-drive ([drive]). Quotes around a value may be left out; what follows a blank "
          "and # or ; is a comment. "
          "Relative paths begin at the folder of this file; in paths $NAME and ${NAME} are taken from the environment. "
          "live: a change takes effect in a running daemon; restart: at its next start.");
  for (const Section& section : sections()) {
    out << '\n';
    comment(out, section.help);
    out << '[' << section.name << "]\n";
    for (const Parameter& row : parameters())
      if (row.section == section.name) print(out, row, config);
  }
}

}  // namespace vdisp
