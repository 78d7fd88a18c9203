// reference.cpp: the parameters as a manual page and as a page of docs/.
// SPDX-License-Identifier: Apache-2.0
#include "config/reference.h"

#include <ostream>

#include "config/parameters.h"

namespace vdisp {
namespace {

/// Text as roff shows it letter by letter.
std::string roff(std::string_view text) {
  std::string out;
  if (!text.empty() && (text[0] == '.' || text[0] == '\'')) out = "\\&";
  for (const char c : text) {
    if (c == '\\') {
      out += "\\e";
    } else if (c == '-') {
      out += "\\-";
    } else if (c == '`') {
      out += "\\(ga";
    } else if (c == '"') {
      out += "\\(dq";
    } else if (c == '\'') {
      out += "\\(aq";
    } else {
      out += c;
    }
  }
  return out;
}

/// Text in a cell of a table.
std::string cell(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '|' || c == '<' || c == '*' || c == '_') out += '\\';
    out += c;
  }
  return out;
}

const char* when(const Parameter& row) { return row.when == When::live ? "live" : "restart"; }

}  // namespace

void write_man_page(std::ostream& out) {
  out << R"(.\" Made by scripts/update-reference from config/schema.def; do not edit.
.TH VDISP.CFG 5 2026-11-22 vdisp "File formats"
.SH NAME
vdisp.cfg \- configuration of vdispd
.SH DESCRIPTION
.BR vdispd (1)
reads this file.
It is made of sections, each with a line
.RI [ section ]
and lines
.IR key " = " value .
Names are case sensitive.
A parameter that is not given has its default; all of them with their defaults are printed by
.BR "vdispd \-\-print\-config" ,
and
.B "vdispd \-\-check\-config"
names everything that is wrong with a file, with its line.
.PP
A comment begins with # or ; at the beginning of a line or after a blank.
A value may stand in double quotes, where \e\(dq, \e\e and \e$ stand for \(dq, \e and $,
or in single quotes, where nothing has a meaning of its own.
.PP
Relative paths begin at the folder of the file; those of
.B \-\-set
begin at the working folder.
In paths $NAME and ${NAME} are taken from the environment.
.PP
.B \-\-set
.IR SECTION . KEY = VALUE
goes before what the file says; blanks in the name of a section may be written as underscores.
.PP
The file in appendix C of the report on the CRAB rover (2009) is valid as printed there;
.B coorsize
is taken for
.BR corrsize .
.B angRot
is one angle that stands in two sections: given in one it holds for both, and two different values are refused.
.SH PARAMETERS
Each with what may be given, its default,
and whether a change takes effect in a running daemon (live) or at its next start (restart).
)";
  write_man_section(out);
  out << R"(.SH SEE ALSO
.BR vdispd (1),
.BR vdisp\-drive (1)
)";
}

void write_man_section(std::ostream& out) {
  for (const Section& section : sections()) {
    out << ".SS [" << roff(section.name) << "]\n" << roff(section.help) << '\n';
    for (const Parameter& row : parameters()) {
      if (row.section != section.name) continue;
      out << ".TP\n.B " << roff(row.key) << '\n' << roff(row.help) << "\n.br\n";
      out << "Value: " << roff(row.allowed()) << "; default " << roff(row.default_text()) << "; " << when(row) << ".\n";
    }
  }
}

void write_markdown(std::ostream& out) {
  out << "<!-- Made by scripts/update-reference from config/schema.def; do not edit. -->\n"
         "# Parameters\n\n"
         "What may stand in `vdisp.cfg`. *live* takes effect in a running daemon, *restart* at its next start. How the file is "
         "written\n"
         "is said in `man vdisp.cfg`; how to find good values, in [tuning.md](tuning.md).\n";
  for (const Section& section : sections()) {
    out << "\n## [" << section.name << "]\n" << section.help << "\n\n| key | may be | default | | what it does |\n";
    out << "| --- | --- | --- | --- | --- |\n";
    for (const Parameter& row : parameters()) {
      if (row.section != section.name) continue;
      out << "| `" << row.key << "` | " << cell(row.allowed()) << " | `" << row.default_text() << "` | " << when(row) << " | "
          << cell(row.help) << " |\n";
    }
  }
}

}  // namespace vdisp
