// sheet.cpp: numbers, matrices and sizes out of the words of a YAML or XML file.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/geometry/sheet.h"

#include <charconv>
#include <cmath>

namespace vdisp::calibration {
namespace {

constexpr size_t most_numbers = 64;  // of a matrix in a calibration: more is another file

double number(const std::string& file, const std::string& name, std::string_view word) {
  double value = NAN;
  if (word.starts_with('+')) word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value))
    refuse(file, name + " holds '" + std::string(word.substr(0, 20)) + "', needed are finite numbers");
  return value;
}

}  // namespace

Sheet::Sheet(std::string file, const std::string& content)
    : file_(std::move(file)), words_(content.starts_with("<") ? words_of_xml(file_, content) : words_of_yaml(file_, content)) {}

std::string Sheet::find(std::initializer_list<const char*> names) const {
  for (const char* name : names)
    if (has(name)) return name;
  return "";
}

std::string Sheet::word(std::initializer_list<const char*> names) const {
  const std::string name = find(names);
  const auto found = words_.find(name);
  return found == words_.end() || found->second.empty() ? "" : found->second[0];
}

int Sheet::whole(const std::string& name) const {
  const auto found = words_.find(name);
  const double value = found == words_.end() || found->second.size() != 1 ? NAN : number(file_, name, found->second[0]);
  if (!(value >= 0 && value < 1e6 && value == std::floor(value))) refuse(file_, name + " is no whole number");
  return static_cast<int>(value);
}

std::vector<double> Sheet::list(const std::string& name, int* rows, int* cols) const {
  const bool matrix = words_.contains(name + "/data");
  const auto& words = words_.at(matrix ? name + "/data" : name);
  if (words.empty() || words.size() > most_numbers)
    refuse(file_, name + " has " + std::to_string(words.size()) + " numbers; needed is a matrix (rows, cols, data) or a list of numbers");
  std::vector<double> values;
  for (const std::string& word : words) values.push_back(number(file_, name, word));
  *rows = matrix ? whole(name + "/rows") : 0;
  *cols = matrix ? whole(name + "/cols") : static_cast<int>(values.size());
  if (matrix && static_cast<double>(*rows) * *cols != static_cast<double>(values.size()))
    refuse(file_,
           name + " has " + std::to_string(values.size()) + " numbers, needed are " + std::to_string(*rows) + "x" + std::to_string(*cols));
  return values;
}

std::vector<double> Sheet::numbers(const std::string& name, size_t count, int rows, int cols) const {
  int r = 0, c = 0;
  const std::vector<double> values = list(name, &r, &c);
  const bool vector = cols == 1 && values.size() == count;  // a translation may lie or stand
  if (values.size() != count || (r != 0 && !vector && (r != rows || c != cols)))
    refuse(file_, name + " is " + (r == 0 ? std::to_string(c) + " numbers" : std::to_string(r) + "x" + std::to_string(c)) + ", needed is " +
                      std::to_string(rows) + "x" + std::to_string(cols));
  return values;
}

std::optional<std::array<double, 8>> Sheet::distortion(std::initializer_list<const char*> names) const {
  const std::string name = find(names);
  if (name.empty()) return {};
  int rows = 0, cols = 0;
  const std::vector<double> values = list(name, &rows, &cols);
  const bool padded = values.size() > 8 && std::all_of(values.begin() + 8, values.end(), [](double value) { return value == 0; });
  if (values.size() != 4 && values.size() != 5 && values.size() != 8 && !padded)
    refuse(file_, name + " has " + std::to_string(values.size()) + " coefficients, needed are 4, 5 or 8 (k1 k2 p1 p2 k3 k4 k5 k6)");
  std::array<double, 8> result{};
  std::copy_n(values.begin(), std::min<size_t>(values.size(), 8), result.begin());
  return result;
}

std::optional<std::array<int, 2>> Sheet::image_size() const {
  const std::string width = find({"image_width", "imageWidth", "image_Width"}),
                    height = find({"image_height", "imageHeight", "image_Height"});
  if (!width.empty() && !height.empty()) return std::array{whole(width), whole(height)};
  if (width.empty() != height.empty()) refuse(file_, "has one of image_width and image_height; needed are both");
  const auto size = matrix<2>({"image_size", "imageSize", "size"}, 2, 1);
  if (!size) return {};
  return whole_size(file_, (*size)[0], (*size)[1]);
}

}  // namespace vdisp::calibration
