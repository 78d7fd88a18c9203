// slider.h: a live parameter as a place between its least and its greatest value.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ipc/include/vdisp/control.h"

namespace vdisp {

class Slider {
 public:
  /// Nothing for what is not live, and for texts.
  static std::optional<Slider> of(const ParameterInfo& info);

  const ParameterInfo& info() const { return info_; }
  void take(const ParameterInfo& info) { info_ = info; }
  /// 0 to 1; nothing where the value is the word that some numbers may be instead.
  std::optional<double> place() const;
  /// The value nearest to a place, as it is set: choices by their words, whole numbers in their steps, others with three digits.
  std::string at(double place) const;
  /// The value a step up (1) or down (-1); at an end, and of a word, the same.
  std::string moved(int by) const;
  /// Without its section: "thresh".
  std::string key() const;
  /// "10 [pixel]", "no"
  std::string words() const;
  bool whole() const { return whole_; }

 private:
  double value_at(double place) const;
  double place_of(double value) const;

  ParameterInfo info_;
  std::vector<std::string> choices_;  // empty: a number
  double least_ = 0, most_ = 0, step_ = 1;
  bool whole_ = false;
  bool bent_ = false;  // small values have more room: the range is much wider than what is usual
};

}  // namespace vdisp
