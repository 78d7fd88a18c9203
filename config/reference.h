// reference.h: the parameters as a manual page and as a page of docs/.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <iosfwd>

namespace vdisp {

/// docs/man/vdisp.cfg.5, the whole page.
void write_man_page(std::ostream& out);
/// The parameters alone, as sections of a manual page in roff.
void write_man_section(std::ostream& out);
/// docs/parameters.md
void write_markdown(std::ostream& out);

}  // namespace vdisp
