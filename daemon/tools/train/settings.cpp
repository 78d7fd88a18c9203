// settings.cpp: what the command line says of front end and network, checked.
// SPDX-License-Identifier: Apache-2.0
#include <sysexits.h>

#include <charconv>
#include <sstream>

#include "config/config.h"
#include "daemon/stages/features.h"
#include "daemon/tools/train/words.h"

namespace vdisp::train {
namespace {

constexpr int paper_width = 320, paper_height = 240;  // px

[[noreturn]] void refuse(const std::string& what) { throw ToolError(EX_USAGE, what); }

void read_size(const std::string& text, snow::Settings& settings) {
  const size_t cross = text.find('x');
  const auto number = [&](size_t from, size_t to, uint32_t& value) {
    const auto [end, error] = std::from_chars(text.data() + from, text.data() + to, value);
    return error == std::errc() && end == text.data() + to && value <= 8192;
  };
  if (cross == std::string::npos || !number(0, cross, settings.width) || !number(cross + 1, text.size(), settings.height))
    refuse("--size " + text + ": needed is WIDTHxHEIGHT, such as 320x240");
  if (settings.width < snow::columns || settings.height < snow::rows) refuse("--size " + text + ": is less than the features' 80x60");
}

template <class Value>
void take(const std::optional<Value>& chosen, Value& value) {
  if (chosen) value = *chosen;
}

}  // namespace

snow::Smooth smooth_named(const std::string& name) {
  if (name == "none") return snow::Smooth::none;
  return name == "mean" ? snow::Smooth::mean : snow::Smooth::median;
}

snow::Settings census_of(const std::string& path) {
  Config config;
  if (const ConfigReading reading = read_config(path, {}, config); !reading.complaints.empty()) {
    std::ostringstream text;
    text << reading.complaints.front();
    throw ToolError(reading.exit_code, text.str());
  }
  return front_end(config, {Pixel::gray8, 0, paper_width, paper_height});
}

snow::Settings settings_of(const Chosen& chosen, snow::Settings base) {
  if (!chosen.encoding.empty()) base.encoding = *snow::encoding_named(chosen.encoding);
  if (!chosen.smooth.empty()) base.smooth = smooth_named(chosen.smooth);
  if (!chosen.size.empty()) read_size(chosen.size, base);
  take(chosen.disparities, base.disparities);
  take(chosen.block, base.block);
  take(chosen.confidence, base.confidence);
  if (base.block % 2 == 0) refuse("--block " + std::to_string(base.block) + ": must be odd");
  if (base.disparities % 16 != 0) refuse("--width " + std::to_string(base.disparities) + ": must be a multiple of 16");
  return base;
}

snow::Winnow winnow_of(const Chosen& chosen, snow::Winnow base) {
  take(chosen.theta, base.theta);
  take(chosen.alpha, base.alpha);
  take(chosen.beta, base.beta);
  take(chosen.initial, base.initial);
  take(chosen.above, base.above);
  take(chosen.below, base.below);
  take(chosen.passes, base.passes);
  take(chosen.seed, base.seed);
  if (!(base.alpha > 1)) refuse("--alpha must be more than 1: it promotes");
  if (!(base.beta > 0 && base.beta < 1)) refuse("--beta must be between 0 and 1: it demotes");
  // Weights are kept between 1e-30 and 1e30, and begin with theta / features of a pair.
  if (!(base.theta >= 1e-6 && base.theta <= 1e6)) refuse("--theta must be from 1e-6 to 1e6");
  return base;
}

}  // namespace vdisp::train
