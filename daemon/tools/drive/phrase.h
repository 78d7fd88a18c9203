// phrase.h: what is said to the motor controller: a text of the configuration with fields that are filled for each command.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace vdisp::drive {

/// What a command says. Wheels are in the controller's units.
struct Motion {
  double left = 0, right = 0;  ///< wheels, m/s times [drive] wheelScale
  double speed = 0, turn = 0;  ///< m/s ahead, rad/s to the left
};

/// One line: what was found in the text, and what would be right.
class PhraseError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// "!M {left} {right}\r": fields {left} and {right} are whole numbers, {speed} and {turn} have three decimals, {left:.2} has two;
/// {{ and }} are plain braces; \r \n \t \\ and \xHH are bytes.
class Phrase {
 public:
  Phrase() = default;
  /// Throws PhraseError.
  explicit Phrase(std::string_view text);

  bool empty() const { return parts_.empty(); }
  bool has_fields() const;
  /// Both wheels, or speed and turn: what it takes to drive.
  bool tells_motion() const;
  /// Writes the text for this motion; allocates nothing. Returns its bytes, 0 where they do not fit.
  size_t fill(const Motion& motion, std::span<char> to) const noexcept;

 private:
  enum class Field { none, left, right, speed, turn };
  struct Part {
    std::string text;  // of Field::none
    Field field = Field::none;
    int decimals = 0;
  };
  bool has(Field field) const;
  static Part field(std::string_view inside);

  std::vector<Part> parts_;
};

/// Bytes as they may stand in a line for people: \r, \n, \x07.
std::string escaped(std::string_view bytes);

}  // namespace vdisp::drive
