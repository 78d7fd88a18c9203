// sheet.cpp: vdisp-probe sheet: all stages of one frame on one page.
// SPDX-License-Identifier: Apache-2.0
#include "ipc/png.h"
#include "probe/contact_sheet.h"
#include "probe/frame_set.h"
#include "probe/terminal.h"

namespace vdisp {

int sheet(const Options& options) {
  stop_on_signals();
  Client client(options.name);
  attach(client, options);
  FrameSet set(client, {});
  if (!set.next()) return 0;
  std::vector<SheetEntry> entries;
  for (size_t i = 0; i < set.size(); ++i) entries.push_back({set.name(i), &set.image(i)});
  const Picture page = contact_sheet(entries, set.picture_rows());
  write_file(options.output, encode_png(PngKind::rgb8, page.width(), page.height(), [&](int y) { return page.row(y); }));
  print(options.output.string() + ": frame " + std::to_string(set.image(0).sequence) + ", " + std::to_string(set.size()) + " stages\n");
  return 0;
}

}  // namespace vdisp
