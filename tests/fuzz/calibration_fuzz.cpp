// calibration_fuzz.cpp: any text as each calibration format: refused in one line, or read, written and read back.
// SPDX-License-Identifier: Apache-2.0
//
// With clang a libFuzzer target; with another compiler tests/fuzz/mutations.cpp feeds it mutated seeds. VDISP_FUZZ_FORMAT: which parser.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <opencv2/core/utility.hpp>

#include "daemon/geometry/calibration_write.h"
#include "daemon/geometry/stereo_parts.h"

namespace vdisp::calibration {
namespace {

constexpr const char* between = "\n=====\n";  // of the two files of a pair

std::array<NamedText, 2> pair_of(const std::string& text) {
  const size_t at = text.find(between);
  if (at == std::string::npos) return {NamedText{"left", text}, NamedText{"right", text}};
  return {NamedText{"left", text.substr(0, at)}, NamedText{"right", text.substr(at + 7)}};
}

StereoParts parse(const std::string& text, bool option) {
  const ReadingOptions options{option, option};
  const std::string format = VDISP_FUZZ_FORMAT;
  if (format == "svs") return parse_svs("file", text, options);
  if (format == "kitti") return parse_kitti("file", text, options);
  if (format == "opencv") return parse_opencv("file", text);
  if (format == "euroc") return parse_euroc(pair_of(text));
  return parse_ros(pair_of(text));
}

void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "broken: %s\n", what);
  std::abort();
}

void try_text(const std::string& text, bool option) {
  Calibration c;
  try {
    c = assemble_from("file", [&] { return parse(text, option); });
  } catch (const CalibrationError& error) {
    require(std::string(error.what()).find('\n') == std::string::npos, "a refusal is one line");
    return;
  }
  require(std::isfinite(c.view.f) && c.view.f > 0 && c.view.baseline > 0 && std::isfinite(c.view.baseline),
          "what is read has f and baseline");
  const std::string written = calibration_texts(c, CalibrationFormat::opencv)[0].content;
  const Calibration back = assemble_from("written", [&] { return parse_opencv("written", written); });
  require(std::abs(back.view.f - c.view.f) <= 1e-9 * c.view.f && back.raw.has_value() == c.raw.has_value(), "what is written reads back");
}

}  // namespace
}  // namespace vdisp::calibration

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const bool quiet = [] {
    cv::redirectError([](int, const char*, const char*, const char*, int, void*) { return 0; });
    return true;
  }();
  // read_text() lets neither of these through.
  if (size < 2 || size > (1 << 20) || !quiet) return 0;
  const std::string text(reinterpret_cast<const char*>(data), size);
  if (text.find('\0') != std::string::npos) return 0;
  for (bool option : {false, true}) vdisp::calibration::try_text(text, option);
  return 0;
}
