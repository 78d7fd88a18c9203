// recording_writer.cpp: pictures first, then the lines that name them: whenever it is cut off, what is listed is whole.
// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

#include "ipc/recording_text.h"

namespace vdisp {
namespace {

namespace fs = std::filesystem;

int open_for_lines(const fs::path& path) {
  const int file = open(path.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
  if (file < 0) throw write_error("cannot write", path, errno);
  return file;
}

}  // namespace

RecordingWriter::RecordingWriter(fs::path folder, const RecordingInfo& info, const std::vector<std::pair<std::string, std::string>>& texts)
    : folder_(std::move(folder)), info_(info) {
  if (!folder_.has_filename()) folder_ = folder_.parent_path();
  std::error_code error;
  for (const char* file : {"recording.json", "index.csv"})
    if (fs::exists(folder_ / file, error))
      throw WriteError(73, folder_.string() + ": holds a recording already; name an empty or a new folder");
  for (const char* side : {"left", "right"}) {
    fs::create_directories(folder_ / side, error);
    if (error) throw write_error("cannot create", folder_ / side, error.value());
  }
  for (const auto& [file, text] : texts) write_file(folder_ / file, text);
  write_file(folder_ / "inputs.csv", recording::steps_head() + "\n");
  write_file(folder_ / "index.csv", std::string(recording::index_head) + "\n");
  write_file(folder_ / "recording.json", recording::info_text(info));
  index_ = open_for_lines(folder_ / "index.csv");
  try {
    inputs_ = open_for_lines(folder_ / "inputs.csv");
  } catch (...) {
    close(index_);
    throw;
  }
}

RecordingWriter::~RecordingWriter() {
  close(index_);
  close(inputs_);
}

void RecordingWriter::add(const RecordedStep& step, const RecordedViews* views) {
  RecordedPair pair;
  if (views) {
    pair = {step.timestamp_ns, views->label, views->speed, views->turn_rate};
    if (step.timestamp_ns <= last_ns_)
      throw WriteError(74, folder_.string() + ": the recording ends: a pair of time " + std::to_string(step.timestamp_ns) +
                               " ns follows one of " + std::to_string(last_ns_) + "; times of pairs must rise");
  }
  try {
    if (views) write_pictures(pair, *views);
    append(inputs_, "inputs.csv", recording::step_line(step, steps_ == 0 || step.sequence != last_sequence_ + 1));
    if (views) append(index_, "index.csv", recording::index_line(pair));
  } catch (const WriteError&) {
    std::error_code ignored;
    for (const char* side : {"left", "right"})
      if (views) fs::remove(folder_ / picture_name(side, pair), ignored);
    throw;
  }
  ++steps_;
  last_sequence_ = step.sequence;
  if (!views) return;
  last_ns_ = step.timestamp_ns;
  ++pairs_;
}

void RecordingWriter::write_pictures(const RecordedPair& pair, const RecordedViews& views) {
  for (const auto& [side, rows] : {std::pair{"left", views.left}, std::pair{"right", views.right}}) {
    const auto row = [&, rows = rows](int y) { return rows + static_cast<size_t>(y) * views.stride; };
    write_file(folder_ / picture_name(side, pair), encode_png(PngKind::gray8, info_.width, info_.height, row));
  }
}

/// A line whole or not at all, as far as the file system lets it: the reader passes over half of one at the end.
void RecordingWriter::append(int file, const char* name, const std::string& line) {
  struct stat status {};
  const bool known = fstat(file, &status) == 0;
  size_t done = 0;
  while (done < line.size()) {
    const ssize_t written = write(file, line.data() + done, line.size() - done);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) {
      const int error = written < 0 ? errno : ENOSPC;
      if (known && ftruncate(file, status.st_size) != 0) {
      }  // then half a line stays, which is passed over
      throw write_error("cannot write", folder_ / name, error);
    }
    done += static_cast<size_t>(written);
  }
}

}  // namespace vdisp
