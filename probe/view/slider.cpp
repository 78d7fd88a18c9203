// slider.cpp: reads the words in which the daemon says what may be given.
// SPDX-License-Identifier: Apache-2.0
#include "probe/view/slider.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "probe/format.h"

namespace vdisp {
namespace {

constexpr double key_step = 0.01;  // of the way, where single steps of the value are smaller

constexpr const char* measures[] = {"m", "s", "rad", "m/s", "rad/s", "Hz", "us", "dB"};

bool is_whole(double value) { return value == std::floor(value); }

/// The number in front; moves `text` behind it.
bool take_number(std::string_view& text, double& value) {
  char* end = nullptr;
  const std::string copy(text);
  value = std::strtod(copy.c_str(), &end);
  const auto used = static_cast<size_t>(end - copy.c_str());
  text.remove_prefix(used);
  return used > 0;
}

bool take_words(std::string_view& text, std::string_view words) {
  if (!text.starts_with(words)) return false;
  text.remove_prefix(words.size());
  return true;
}

/// "none, mean or median"
std::vector<std::string> words_of(std::string text) {
  for (size_t at = text.find(" or "); at != std::string::npos; at = text.find(" or ")) text.replace(at, 4, ", ");
  std::vector<std::string> words;
  while (!text.empty()) {
    const size_t end = std::min(text.find(", "), text.size());
    words.push_back(text.substr(0, end));
    text.erase(0, end + 2);
  }
  return words;
}

}  // namespace

std::optional<Slider> Slider::of(const ParameterInfo& info) {
  if (!info.live || info.allowed.starts_with("a text") || info.allowed.starts_with("a path")) return std::nullopt;
  Slider slider;
  slider.info_ = info;
  std::string_view text = info.allowed;
  if (!take_words(text, "a number from ")) {
    slider.choices_ = words_of(info.allowed);
    return slider.choices_.size() > 1 ? std::optional(slider) : std::nullopt;
  }
  const bool known = take_number(text, slider.least_) && take_words(text, " to ") && take_number(text, slider.most_);
  if (!known || !(slider.most_ > slider.least_)) return std::nullopt;
  if (take_words(text, " in steps of ") && !take_number(text, slider.step_)) return std::nullopt;
  // The daemon does not say which numbers are whole ones: those that are counted, not measured.
  char* end = nullptr;
  const double standard = std::strtod(info.standard.c_str(), &end);
  const bool measured = std::any_of(std::begin(measures), std::end(measures), [&](const char* unit) { return info.unit == unit; });
  slider.whole_ = !measured && is_whole(slider.least_) && is_whole(slider.most_) && is_whole(standard) && end != info.standard.c_str();
  slider.bent_ = slider.least_ >= 0 && end != info.standard.c_str() && standard - slider.least_ < 0.05 * (slider.most_ - slider.least_) &&
                 (!slider.whole_ || slider.most_ - slider.least_ > 200 * slider.step_);
  return slider;
}

double Slider::value_at(double place) const {
  const double share = std::clamp(place, 0.0, 1.0);
  return least_ + (most_ - least_) * (bent_ ? share * share * share : share);
}

double Slider::place_of(double value) const {
  const double share = std::clamp((value - least_) / (most_ - least_), 0.0, 1.0);
  return bent_ ? std::cbrt(share) : share;
}

std::optional<double> Slider::place() const {
  if (!choices_.empty()) {
    const auto found = std::find(choices_.begin(), choices_.end(), info_.value);
    if (found == choices_.end()) return std::nullopt;
    return static_cast<double>(found - choices_.begin()) / static_cast<double>(choices_.size() - 1);
  }
  char* end = nullptr;
  const double value = std::strtod(info_.value.c_str(), &end);
  if (end == info_.value.c_str() || !std::isfinite(value)) return std::nullopt;
  return place_of(value);
}

std::string Slider::at(double place) const {
  if (!choices_.empty()) {
    const double last = static_cast<double>(choices_.size() - 1);
    return choices_[static_cast<size_t>(std::lround(std::clamp(place, 0.0, 1.0) * last))];
  }
  const double value = value_at(place);
  if (whole_) return format("%.0f", std::min(least_ + step_ * std::round((value - least_) / step_), most_));
  // Three digits, but never out of the range.
  return format("%.10g", std::clamp(std::strtod(format("%.3g", value).c_str(), nullptr), least_, most_));
}

std::string Slider::moved(int by) const {
  const std::optional<double> here = place();
  if (!here) return choices_.empty() ? at(place_of(std::clamp(0.0, least_, most_))) : choices_.front();
  if (!choices_.empty()) return at(*here + by / static_cast<double>(choices_.size() - 1));
  const double value = std::strtod(info_.value.c_str(), nullptr);
  if (whole_) {
    const double next = std::strtod(at(*here + by * key_step).c_str(), nullptr);
    const double least_next = std::clamp(value + by * step_, least_, most_);
    return format("%.0f", by > 0 ? std::max(next, least_next) : std::min(next, least_next));
  }
  const std::string next = at(*here + by * key_step);
  return std::strtod(next.c_str(), nullptr) == value ? at(*here + 2 * by * key_step) : next;
}

std::string Slider::key() const { return info_.key.substr(info_.key.rfind('.') + 1); }

std::string Slider::words() const {
  const bool number = choices_.empty() && place().has_value();
  return number && !info_.unit.empty() && info_.unit != "-" ? info_.value + " [" + info_.unit + "]" : info_.value;
}

}  // namespace vdisp
