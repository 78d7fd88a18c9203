// parameters.h: every parameter of schema.def as a row that can be named, explained, read and set.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "config/config.h"

namespace vdisp {

enum class When { live, restart };  ///< takes effect between two frames, or at the next start
enum class Kind { whole, real, flag, text, path, choice };

struct Section {
  std::string_view name;  ///< as in the file: "image source"
  std::string_view help;
};

/// One row of schema.def.
struct Parameter {
  /// Where the value is in a Config.
  using Field = std::variant<int& (*)(Config&), double& (*)(Config&), bool& (*)(Config&), std::string& (*)(Config&)>;

  std::string_view section, key, help;
  std::string_view unit;  ///< "-": a pure number; empty: no number
  Kind kind;
  When when;
  Field field;
  double least = 0, most = 0;
  int step = 1;            ///< of a whole number, counted from `least`
  std::string_view words;  ///< of a choice: "a|b|c"; of a number: the word it may be instead, or empty

  /// "image source.ndisp"
  std::string name() const;
  /// What may be given: "a number from 16 to 256 in steps of 16 [pixel]".
  std::string allowed() const;
  std::string default_text() const;
  /// Plain, without quotes; floats with as many digits as it takes to read them back.
  std::string get(const Config& config) const;
  /// Takes what get() gives. Otherwise one line, what was found and what would be right, and `config` is unchanged.
  /// `angRot` is one value that stands in two sections: setting either sets both. Call check() when all is set.
  std::optional<std::string> set(Config& config, std::string_view text) const;
  /// Swaps the value of both, angRot in both its sections: no allocation, for a running daemon.
  void exchange(Config& one, Config& other) const noexcept;
};

/// In the order of schema.def.
std::span<const Section> sections();
std::span<const Parameter> parameters();
/// Null where there is none.
const Parameter* find_parameter(std::string_view section, std::string_view key);
/// "image source.ndisp" or "image_source.ndisp".
const Parameter* find_parameter(std::string_view name);
/// The name with its spaces, where it was given with underscores instead; else as it was given.
std::string section_name(std::string_view given);

}  // namespace vdisp
