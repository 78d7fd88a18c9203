// comparison.h: the same frames under the daemon's configuration and under another one, for compare.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "ipc/image.h"
#include "probe/words.h"

namespace vdisp {

/// One image as vdispd --dump --images wrote it.
class StoredImage {
 public:
  /// Throws ProbeError (74) where the file is not a whole image.
  explicit StoredImage(const std::filesystem::path& file);
  const Image& image() const { return *reinterpret_cast<const Image*>(memory_.get()); }

 private:
  struct Free {
    void operator()(std::byte* memory) const { std::free(memory); }
  };
  std::unique_ptr<std::byte[], Free> memory_;
};

/// Pixels of a disparity that were measured, cells of an occupancy that are obstacles; what is counted is empty for other stages.
struct Count {
  const char* what = "";
  uint64_t before = 0, after = 0;
};

/// One stage, old and new.
struct ComparedStage {
  std::string topic;
  StoredImage before, after;
  uint64_t pixels = 0, differing = 0;  ///< of pictures of one size
  Count count{};
  bool comparable() const { return before.image().spec == after.image().spec && before.image().valid() && after.image().valid(); }
};

struct Comparison {
  std::vector<std::string> changes;  ///< "image source.thresh: 10 -> 20"
  uint64_t frames = 0;               ///< so many pairs were taken
  uint64_t first = 0, last = 0;      ///< the daemon's numbers of them; the last one is compared
  int picture_rows = 0;
  std::vector<ComparedStage> stages;  ///< in the daemon's order, those that both have
};

/// Takes `options.frames` rectified pairs from the daemon, and has a vdispd of its own, the program beside this one, make all stages of
/// them twice: as the daemon is configured now, and with options.sets (KEY=VALUE). Throws ProbeError: 64 a key that cannot be compared
/// so, 69 no daemon or no frames, 78 a value that is refused.
Comparison compare_frames(const Options& options);

}  // namespace vdisp
