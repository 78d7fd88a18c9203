// make_model.cpp: a model file with weights made by hand, for tests: make_model FILE [KEY=VALUE]...
// SPDX-License-Identifier: Apache-2.0
#include <cstdlib>
#include <iostream>
#include <map>
#include <string>
#include <vector>

#include "daemon/snow/encoding.h"
#include "daemon/snow/model.h"

using namespace vdisp::snow;

/// Each weight is the same but those of pixels with a value from `near` on (for contours: rows), which speak for obstacle by `weight`; in
/// the left half of the columns for right, in the right one for left.
int main(int argc, char** argv) {
  std::map<std::string, std::string> given{
      {"encoding", "depth-map"}, {"width", "320"}, {"height", "240"}, {"disparities", "32"}, {"block", "9"},       {"smooth", "mean"},
      {"confidence", "0.8"},     {"near", "40"},   {"weight", "1"},   {"theta", "100"},      {"sensitivity", "0"}, {"clear", "1"}};
  for (int i = 2; i < argc; ++i) {
    const std::string word = argv[i];
    given[word.substr(0, word.find('='))] = word.substr(word.find('=') + 1);
  }
  const auto number = [&](const char* key) { return std::strtod(given.at(key).c_str(), nullptr); };
  const auto whole = [&](const char* key) { return static_cast<uint32_t>(number(key)); };
  ModelParts parts;
  parts.settings = {encoding_named(given["encoding"]).value(),
                    whole("width"),
                    whole("height"),
                    whole("disparities"),
                    whole("block"),
                    given["smooth"] == "mean"     ? Smooth::mean
                    : given["smooth"] == "median" ? Smooth::median
                                                  : Smooth::none,
                    number("confidence")};
  std::vector<float> free(vector_length, 0.01f), obstacle = free, left = free, right = free;
  const bool rows_are_near = parts.settings.encoding != Encoding::disparity_map;
  for (int x = 0; x < columns; ++x) {
    for (int y = 0; y < rows; ++y) {
      for (int value = 0; value < 256; ++value) {
        const bool something = parts.settings.encoding == Encoding::contour || value > 3;
        if (!something || (rows_are_near ? y : value) < static_cast<int>(whole("near"))) continue;
        const uint32_t id = feature_id(x, y, value);
        obstacle[id] += static_cast<float>(number("weight"));
        (x < columns / 2 ? right : left)[id] += static_cast<float>(number("weight"));
      }
    }
  }
  parts.obstacle.winnow.theta = parts.direction.winnow.theta = number("theta");
  parts.obstacle.sensitivity = parts.direction.sensitivity = number("sensitivity");
  parts.obstacle.clear = number("clear");
  parts.free = free;
  parts.obstacles = obstacle;
  parts.left = left;
  parts.right = right;
  try {
    write_model(argv[1], parts);
  } catch (const ModelError& error) {
    std::cerr << error.what() << '\n';
    return error.exit_code;
  }
  return 0;
}
