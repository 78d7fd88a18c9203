// model_numbers.cpp: what the numbers of a model have to be; a checksum says that they were meant, not that they make sense.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <sstream>

#include "daemon/snow/model_file.h"

namespace vdisp::snow {
namespace {

template <class Number>
std::string found(const char* what, Number value, const char* needed) {
  std::ostringstream text;
  text << what << " is " << value << ", needed is " << needed;
  return text.str();
}

std::string nonsense_in(const Settings& s) {
  if (name(s.encoding) == "unknown") return found("its encoding", static_cast<uint32_t>(s.encoding), "1 to 4");
  if (s.width < columns || s.width > 8192) return found("the width of its views", s.width, "80 to 8192");
  if (s.height < rows || s.height > 8192) return found("the height of its views", s.height, "60 to 8192");
  if (s.disparities < 16 || s.disparities > 256 || s.disparities % 16) return found("its search width", s.disparities, "16 to 256, by 16");
  if (s.block < 3 || s.block > 21 || s.block % 2 == 0) return found("its block", s.block, "an odd number from 3 to 21");
  if (s.smooth > Smooth::median) return found("its smoothing", static_cast<uint32_t>(s.smooth), "0 to 2");
  if (!(s.confidence >= 0 && s.confidence <= 8)) return found("its confidence", s.confidence, "0 to 8");
  return "";
}

std::string nonsense_in(const Trained& t) {
  const Winnow& w = t.winnow;
  if (!(w.theta > 0 && std::isfinite(w.theta))) return found("theta", w.theta, "a number above 0");
  if (!(w.alpha > 1 && std::isfinite(w.alpha))) return found("alpha", w.alpha, "a number above 1");
  if (!(w.beta > 0 && w.beta < 1)) return found("beta", w.beta, "a number between 0 and 1");
  for (const double value : {w.initial, w.above, w.below, t.initial})
    if (!(value >= 0 && std::isfinite(value))) return found("a parameter of the training", value, "a number from 0 on");
  if (!std::isfinite(t.sensitivity)) return found("the sensitivity", t.sensitivity, "a number");
  if (!(t.clear > 0 && std::isfinite(t.clear))) return found("what is clear", t.clear, "a number above 0");
  return "";
}

}  // namespace

std::string nonsense_in(const Settings& settings, const Trained& obstacle, const Trained& direction) {
  if (auto text = nonsense_in(settings); !text.empty()) return text;
  if (auto text = nonsense_in(obstacle); !text.empty()) return "obstacle classifier: " + text;
  if (auto text = nonsense_in(direction); !text.empty()) return "direction classifier: " + text;
  return "";
}

std::string nonsense_in(std::span<const float> weights) {
  const auto sound = [](float weight) { return (weight >= 0) & (weight <= std::numeric_limits<float>::max()); };
  // Without a branch for each of them: most models are sound, and have eight million.
  const bool all = std::transform_reduce(weights.begin(), weights.end(), true, std::bit_and<bool>(), sound);
  if (all) return "";
  const auto wrong = std::find_if_not(weights.begin(), weights.end(), sound);
  return wrong == weights.end() ? "" : found("a weight", *wrong, "a number from 0 on");
}

}  // namespace vdisp::snow
