// recording_fuzz.cpp: any text as the files of a recording: refused in one line, or read, written and read back the same.
// SPDX-License-Identifier: Apache-2.0
//
// The first letter says which file the rest is: i the lines of index.csv, s those of inputs.csv, I and S with their heads, j
// recording.json.
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "ipc/recording_text.h"

namespace vdisp::recording {
namespace {

void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "broken: %s\n", what);
  std::abort();
}

std::string index_text(const std::vector<RecordedPair>& pairs) {
  std::string text = std::string(index_head) + "\n";
  for (const RecordedPair& pair : pairs) text += index_line(pair);
  return text;
}

std::string steps_text(const std::vector<RecordedStep>& steps) {
  std::string text = steps_head() + "\n";
  for (const RecordedStep& step : steps) text += step_line(step, true);
  return text;
}

void try_index(const std::string& text) {
  size_t cut = 0;
  const auto pairs = read_index("index.csv", text, cut);
  const std::string written = index_text(pairs);
  const auto again = read_index("written", written, cut);
  require(index_text(again) == written && again.size() == pairs.size(), "an index that was written reads back");
  for (size_t i = 1; i < pairs.size(); ++i) require(pairs[i].timestamp_ns > pairs[i - 1].timestamp_ns, "times rise");
}

void try_steps(const std::string& text) {
  size_t cut = 0;
  const auto steps = read_steps("inputs.csv", text, cut);
  const std::string written = steps_text(steps);
  require(steps_text(read_steps("written", written, cut)) == written, "steps that were written read back");
}

void try_info(const std::string& text) {
  const std::string written = info_text(read_info("recording.json", text));
  require(info_text(read_info("written", written)) == written, "a description that was written reads back");
}

}  // namespace

void try_text(char kind, const std::string& text) {
  try {
    switch (kind) {
      case 'i': return try_index(std::string(index_head) + "\n" + text);
      case 's': return try_steps(steps_head() + "\n" + text);
      case 'I': return try_index(text);
      case 'S': return try_steps(text);
      default: return try_info(text);
    }
  } catch (const RecordingError& error) {
    require(std::string(error.what()).find('\n') == std::string::npos, "a refusal is one line");
  }
}

}  // namespace vdisp::recording

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size < 2 || size > (1 << 20)) return 0;
  vdisp::recording::try_text(static_cast<char>(data[0]), std::string(reinterpret_cast<const char*>(data) + 1, size - 1));
  return 0;
}
