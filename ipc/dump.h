// dump.h: writes the images of one frame to a folder, in the format of --dump that evaluation scripts read.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "ipc/image.h"
#include "ipc/png.h"

namespace vdisp {

/// The folder of one frame, DIR/000000. It is filled as DIR/.000000.part and gets its name in finish(): a frame is complete or
/// absent. Without finish() nothing remains. Equal images give equal bytes. All calls but the destructor throw WriteError.
class FrameDump {
 public:
  /// Creates the folders above as well. A folder that exists already is refused (73): two runs are never mixed.
  explicit FrameDump(std::filesystem::path folder);
  ~FrameDump();
  FrameDump(const FrameDump&) = delete;
  FrameDump& operator=(const FrameDump&) = delete;

  /// Pictures become files, records members of frame.json; of a blind image only its reason is written, and of a blind line the
  /// head of its table. `catalogue`,
  /// `heartbeat`, `recorder` and `calibration` tell of the daemon, not of the frame, and are passed over.
  void add(std::string_view topic, const Image& image);
  /// One more file in the frame's folder; folders in `name` are created.
  void add_file(const std::string& name, std::string_view bytes);
  /// Time that a stage took, for timing.json; without any there is no such file.
  void add_timing(std::string_view stage, int64_t ns);
  /// `left`, `right`: names of the files the pair was read from; empty (null in the file) where that is not known.
  void finish(const std::string& left = {}, const std::string& right = {});

 private:
  struct Json;
  void add_picture(const std::string& topic, const Image& image);

  std::filesystem::path folder_, part_;
  std::unique_ptr<Json> json_;
};

/// True for topics whose images carry a GridGeometry: `map`, `truth/map`, `map_...`.
bool is_grid(std::string_view topic);

/// Six digits or more: the name of a frame's folder.
std::string frame_name(uint64_t number);

}  // namespace vdisp
