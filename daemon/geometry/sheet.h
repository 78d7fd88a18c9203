// sheet.h: the names and numbers in a YAML or XML file as calibrations are written; inside this room only.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <initializer_list>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "daemon/geometry/stereo_parts.h"

namespace vdisp::calibration {

/// The words at each place of a text; places are names within names. `file` is for messages.
using Words = std::map<std::string, std::vector<std::string>>;
Words words_of_yaml(const std::string& file, const std::string& content);
Words words_of_xml(const std::string& file, const std::string& content);

/// Names within names (P1/data), each with the words that stand there. Of YAML: maps by indentation, lists in brackets or with a line for
/// each item, comments, tags; of XML: elements and their text. OpenCV's own reader of both is not used: damaged files crash it (4.6).
/// Throws CalibrationError with the line for what is neither.
class Sheet {
 public:
  Sheet(std::string file, const std::string& content);

  const std::string& file() const { return file_; }
  bool has(const std::string& name) const { return words_.contains(name) || words_.contains(name + "/data"); }

  /// A matrix of this size by the first of its names that is there: rows, cols and data, or a plain list of as many numbers.
  template <size_t n>
  std::optional<std::array<double, n>> matrix(std::initializer_list<const char*> names, int rows, int cols) const {
    const std::string name = find(names);
    if (name.empty()) return {};
    const std::vector<double> values = numbers(name, n, rows, cols);
    std::array<double, n> result{};
    std::copy_n(values.begin(), n, result.begin());
    return result;
  }
  std::optional<std::array<double, 8>> distortion(std::initializer_list<const char*> names) const;
  /// Width and height by any of their names; absent where the file has none of them.
  std::optional<std::array<int, 2>> image_size() const;
  /// Empty where the file has none of the names.
  std::string word(std::initializer_list<const char*> names) const;

 private:
  std::string find(std::initializer_list<const char*> names) const;
  std::vector<double> list(const std::string& name, int* rows, int* cols) const;
  std::vector<double> numbers(const std::string& name, size_t count, int rows, int cols) const;
  int whole(const std::string& name) const;

  std::string file_;
  Words words_;
};

}  // namespace vdisp::calibration
