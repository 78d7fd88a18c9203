// natural_order.h: the order in which people count file names.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cctype>
#include <string>
#include <string_view>

namespace vdisp {

inline bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

/// Numbers in numeric order: left2 before left10.
inline bool natural_less(std::string_view a, std::string_view b) {
  const std::string_view all_a = a, all_b = b;
  const auto number = [](std::string_view& s) {
    const size_t length = static_cast<size_t>(std::find_if_not(s.begin(), s.end(), is_digit) - s.begin());
    std::string_view digits = s.substr(0, length);
    s.remove_prefix(length);
    digits.remove_prefix(std::min(digits.find_first_not_of('0'), digits.size()));
    return digits;
  };
  while (!a.empty() && !b.empty()) {
    if (is_digit(a[0]) && is_digit(b[0])) {
      const std::string_view m = number(a), n = number(b);
      if (m.size() != n.size()) return m.size() < n.size();
      if (m != n) return m < n;
    } else {
      if (a[0] != b[0]) return a[0] < b[0];
      a.remove_prefix(1);
      b.remove_prefix(1);
    }
  }
  return a.empty() != b.empty() ? a.empty() : all_a < all_b;
}
struct NaturalLess {
  bool operator()(const std::string& a, const std::string& b) const { return natural_less(a, b); }
};

}  // namespace vdisp
