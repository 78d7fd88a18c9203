// dump.cpp: vdisp-probe dump: frames from a running daemon, in the format of vdispd --dump.
// SPDX-License-Identifier: Apache-2.0
#include "ipc/dump.h"

#include "probe/frame_set.h"
#include "probe/paint.h"
#include "probe/terminal.h"

namespace vdisp {

int dump(const Options& options) {
  stop_on_signals();
  Client client(options.name);
  attach(client, options);
  FrameSet set(client, options.topics);
  PaintStyle style;
  style.picture_rows = set.picture_rows();
  const uint64_t frames = options.once ? 1 : options.frames;
  uint64_t written = 0;
  for (; written < frames && set.next(); ++written) {
    FrameDump frame(options.output / frame_name(written));
    for (size_t i = 0; i < set.size(); ++i) {
      frame.add(set.name(i), set.image(i));
      if (!options.picture) continue;
      const Picture picture = portrait(set.name(i), set.image(i), style);
      frame.add_file(set.name(i) + "_view.png",
                     encode_png(PngKind::rgb8, picture.width(), picture.height(), [&](int y) { return picture.row(y); }));
    }
    set.release();
    frame.finish();
  }
  print(std::to_string(written) + " frames of " + std::to_string(set.size()) + " stages in " + options.output.string() + "\n");
  return 0;
}

}  // namespace vdisp
