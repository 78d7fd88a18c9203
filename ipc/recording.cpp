// recording.cpp: reads a recording's folder, and tells what is broken from what was only cut off.
// SPDX-License-Identifier: Apache-2.0
#include "ipc/recording.h"

#include <array>
#include <cstring>
#include <fstream>
#include <iterator>

#include "ipc/recording_text.h"

namespace vdisp {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view png_begin{"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16};
constexpr std::string_view png_end{"\0\0\0\0IEND\xae\x42\x60\x82", 12};

std::string text_of(const fs::path& path, const char* needed) {
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    std::error_code error;
    const bool folder = fs::is_directory(path.parent_path(), error);
    throw RecordingError(path.string() + ": " + (folder ? "no such file" : "no such folder") + "; needed is " + needed);
  }
  std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (file.bad()) throw RecordingError(path.string() + ": cannot be read");
  return text;
}

std::string words(int width, int height) { return std::to_string(width) + "x" + std::to_string(height); }

uint32_t big_endian(const char* bytes) {
  uint32_t value = 0;
  for (int i = 0; i < 4; ++i) value = value << 8 | static_cast<uint8_t>(bytes[i]);
  return value;
}

/// Empty where its head is that of a picture of this kind and size.
std::string picture_fault(const fs::path& path, const RecordingInfo& info) {
  std::array<char, 29> head{};
  std::ifstream file(path, std::ios::binary);
  if (!file) return "is missing; needed are both pictures of a pair";
  file.read(head.data(), head.size());
  if (file.gcount() < static_cast<std::streamsize>(head.size()) || std::string_view(head.data(), png_begin.size()) != png_begin)
    return "is no PNG";
  const uint32_t width = big_endian(head.data() + 16), height = big_endian(head.data() + 20);
  if (head[24] != 8 || head[25] != 0 || head[28] != 0) return "is not 8 bit grey";
  if (width == static_cast<uint32_t>(info.width) && height == static_cast<uint32_t>(info.height)) return {};
  return "is " + std::to_string(width) + "x" + std::to_string(height) + ", the recording is " + words(info.width, info.height);
}

/// There, and cut off: the file system had its name before its bytes, which are missing at the end, or zero.
bool cut_short(const fs::path& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) return false;
  std::array<char, png_begin.size()> begin{};
  std::array<char, png_end.size()> end{};
  const auto size = static_cast<std::streamoff>(file.tellg());
  if (size < static_cast<std::streamoff>(begin.size() + end.size())) return true;
  file.seekg(0);
  file.read(begin.data(), begin.size());
  file.seekg(size - static_cast<std::streamoff>(end.size()));
  file.read(end.data(), end.size());
  const std::string_view first(begin.data(), begin.size()), last(end.data(), end.size());
  return (first == png_begin && last != png_end) || first.find_first_not_of('\0') == std::string_view::npos;
}

void read_picture(const fs::path& path, Image& image) {
  const auto refuse = [&](const std::string& what) { throw RecordingError(path.string() + ": " + what); };
  const std::string bytes = text_of(path, "a picture of the recording");
  const ImageSpec& spec = image.spec;
  const std::string fault = decode_gray8(bytes, spec.width, spec.height, [&](int y) { return image.row<uint8_t>(y); });
  if (!fault.empty()) refuse(fault);
}

}  // namespace

RecordingInfo Recording::info_of(const fs::path& folder) {
  const fs::path file = folder / "recording.json";
  return recording::read_info(file.string(), text_of(file, "a recording, as vdispd --record or vdisp-probe record writes it"));
}

Recording::Recording(fs::path folder) : folder_(std::move(folder)) {
  if (!folder_.has_filename()) folder_ = folder_.parent_path();
  const fs::path index = folder_ / "index.csv", inputs = folder_ / "inputs.csv";
  info_ = info_of(folder_);
  pairs_ = recording::read_index(index.string(), text_of(index, "the list of its pairs"), cut_off_);
  if (!known_file("inputs.csv").empty()) {
    steps_ = recording::read_steps(inputs.string(), text_of(inputs, "what came in"), cut_off_);
    match_steps();
  }
  drop_unfinished();
  check_pictures();
}

fs::path Recording::known_file(const char* name) const {
  std::error_code error;
  return fs::is_regular_file(folder_ / name, error) ? folder_ / name : fs::path();
}

/// The line of a step comes before that of its pair: the last step may have none.
void Recording::match_steps() {
  size_t pair = 0;
  for (size_t i = 0; i < steps_.size(); ++i) {
    if (!steps_[i].has_pair()) continue;
    if (pair < pairs_.size() && pairs_[pair].timestamp_ns == steps_[i].timestamp_ns) {
      ++pair;
    } else if (pair == pairs_.size()) {
      cut_off_ += steps_.size() - i;
      steps_.resize(i);
    } else {
      throw RecordingError((folder_ / "inputs.csv").string() + ": step " + std::to_string(steps_[i].sequence) + " has a pair of time " +
                           std::to_string(steps_[i].timestamp_ns) + ", the next in index.csv is " +
                           std::to_string(pairs_[pair].timestamp_ns));
    }
  }
  if (pair == pairs_.size()) return;
  throw RecordingError((folder_ / "inputs.csv").string() + ": no step has the pair of time " + std::to_string(pairs_[pair].timestamp_ns) +
                       ", which index.csv lists");
}

void Recording::drop_unfinished() {
  const size_t before = pairs_.size();
  while (!pairs_.empty() && (cut_short(left(pairs_.size() - 1)) || cut_short(right(pairs_.size() - 1)))) pairs_.pop_back();
  if (pairs_.size() == before) return;
  cut_off_ += before - pairs_.size();
  size_t last = steps_.size(), with_pair = before;
  while (last > 0 && with_pair > pairs_.size()) with_pair -= steps_[--last].has_pair();
  steps_.resize(last);
}

void Recording::check_pictures() {
  for (size_t i = 0; i < pairs_.size(); ++i) {
    for (const fs::path& path : {left(i), right(i)}) {
      const std::string fault = picture_fault(path, info_);
      if (!fault.empty()) throw RecordingError(path.string() + " " + fault);
    }
  }
}

void Recording::read(size_t pair, Image& left_image, Image& right_image) const {
  read_picture(left(pair), left_image);
  read_picture(right(pair), right_image);
}

}  // namespace vdisp
