// dump.h: `--dump DIR`: every stage of every frame as files, for evaluation.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>

#include "daemon/core/driver.h"
#include "ipc/dump.h"

namespace vdisp {

/// Throws WriteError. The images come from within a step, where nothing may be thrown: a write that fails there is kept, and
/// thrown by finish_frame().
class Dump {
 public:
  /// Creates DIR; one that holds frames already is refused, so that two runs are never mixed.
  /// `images`: each image is also written as it is in memory, header and rows: STAGE.image.
  Dump(std::filesystem::path folder, bool images);
  void see(const Topic& topic, const Image& image) noexcept;
  /// After each step; `files`: left and right of the pair.
  void finish_frame(const Driver& driver, const std::pair<std::string, std::string>& files);

 private:
  std::filesystem::path folder_;
  bool images_;
  uint64_t frame_ = 0;
  std::optional<FrameDump> current_;
  std::optional<WriteError> failed_;
};

/// `--dot FILE`: the tree as a Graphviz graph. Throws WriteError.
void write_graph(const Driver& driver, const std::string& file);

}  // namespace vdisp
