// vdisp_schema.cpp: prints what is made from the table of parameters: the shipped vdisp.cfg, its manual page, docs/parameters.md.
// SPDX-License-Identifier: Apache-2.0
#include <sysexits.h>

#include <iostream>
#include <string_view>

#include "config/config.h"
#include "config/reference.h"

int main(int count, char** words) {
  const std::string_view what = count == 2 ? words[1] : "";
  if (what == "config") {
    vdisp::print_config(std::cout, vdisp::Config{});
  } else if (what == "man") {
    vdisp::write_man_page(std::cout);
  } else if (what == "markdown") {
    vdisp::write_markdown(std::cout);
  } else {
    std::cerr << "vdisp-schema: found " << count - 1 << " words" << (count == 2 ? ": " : "") << what
              << "; must be one of config, man, markdown\n";
    return EX_USAGE;
  }
  std::cout.flush();
  return std::cout ? EX_OK : EX_IOERR;
}
