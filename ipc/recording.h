// recording.h: a recorded drive as a folder: labelled pairs, what came in at each step, calibration and configuration.
// SPDX-License-Identifier: Apache-2.0
//
//   recording.json   what it is: version, program, source, world, seed, epoch, size
//   index.csv        a line for each pair: timestamp_ns,label,left,right,speed,turn_rate
//   left/<timestamp_ns>_<label>.png, right/<the same>.png   8 bit grey, raw as the cameras see them
//   inputs.csv       a line for each step, blind ones too: odometry, IMU, order and events as the tree saw them (may be absent)
//   calibration.yml, vdisp.cfg   where there are any
//
// A picture has its name only when it is whole, and a pair its line only when both pictures are there.
#pragma once

#include <cstddef>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "ipc/png.h"
#include "ipc/recorded_step.h"

namespace vdisp {

struct RecordedPair {
  int64_t timestamp_ns = 0;
  Label label = Label::none;
  double speed = std::nan(""), turn_rate = std::nan("");  ///< what the rover was told: m/s, rad/s; NaN: nobody told
  bool operator==(const RecordedPair&) const = default;
};
/// "left/12_forward.png"; side: left or right.
std::string picture_name(std::string_view side, const RecordedPair& pair);

struct RecordingInfo {
  std::string program;  ///< with its version
  std::string source;   ///< sim, files, aravis, ...
  std::string world;    ///< of the simulator; else empty
  uint64_t seed = 0;
  uint64_t epoch = 0;  ///< start of the daemon that saw it
  int width = 0, height = 0;
  bool synthetic = false;  ///< from the simulator or from files
};

/// One line: file, what was found, what would be right.
class RecordingError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
  static constexpr int exit_code = 66;
};

/// Read and checked: every pair has both pictures, of the right kind and size, and times rise. What a write that was cut off left at the
/// end is left out. Throws RecordingError.
class Recording {
 public:
  explicit Recording(std::filesystem::path folder);
  /// What recording.json alone says. Throws RecordingError.
  static RecordingInfo info_of(const std::filesystem::path& folder);

  const std::filesystem::path& folder() const { return folder_; }
  const RecordingInfo& info() const { return info_; }
  const std::vector<RecordedPair>& pairs() const { return pairs_; }
  /// Every step, in order; those with a pair are pairs() one by one. Empty: the recording does not tell.
  const std::vector<RecordedStep>& steps() const { return steps_; }
  std::filesystem::path left(size_t pair) const { return folder_ / picture_name("left", pairs_.at(pair)); }
  std::filesystem::path right(size_t pair) const { return folder_ / picture_name("right", pairs_.at(pair)); }
  /// Empty where there is none.
  std::filesystem::path calibration() const { return known_file("calibration.yml"); }
  std::filesystem::path configuration() const { return known_file("vdisp.cfg"); }
  /// Lines and pairs that were left out as their writing was cut off.
  size_t cut_off() const { return cut_off_; }

  /// Both pictures into gray8 images of info's size. Throws RecordingError where one is damaged.
  void read(size_t pair, Image& left, Image& right) const;

 private:
  std::filesystem::path known_file(const char* name) const;
  void check_pictures();
  void drop_unfinished();
  void match_steps();

  std::filesystem::path folder_;
  RecordingInfo info_;
  std::vector<RecordedPair> pairs_;
  std::vector<RecordedStep> steps_;
  size_t cut_off_ = 0;
};

/// Not for several threads. All calls throw WriteError: 73 cannot be created, 74 the disk is full; what was whole before is kept then.
class RecordingWriter {
 public:
  /// Creates the folder. One that holds a recording already is refused. `texts`: further files, by name (calibration.yml, vdisp.cfg).
  RecordingWriter(std::filesystem::path folder, const RecordingInfo& info,
                  const std::vector<std::pair<std::string, std::string>>& texts = {});
  ~RecordingWriter();
  RecordingWriter(const RecordingWriter&) = delete;
  RecordingWriter& operator=(const RecordingWriter&) = delete;

  /// The next step; `views` where it had a pair, else null. The time of pairs has to rise.
  void add(const RecordedStep& step, const RecordedViews* views);
  uint64_t pairs() const { return pairs_; }
  const std::filesystem::path& folder() const { return folder_; }

 private:
  void append(int file, const char* name, const std::string& line);
  void write_pictures(const RecordedPair& pair, const RecordedViews& views);

  std::filesystem::path folder_;
  RecordingInfo info_;
  int index_ = -1, inputs_ = -1;  // files
  uint64_t pairs_ = 0, steps_ = 0, last_sequence_ = 0;
  int64_t last_ns_ = -1;
};

}  // namespace vdisp
