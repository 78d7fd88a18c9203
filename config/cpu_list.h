// cpu_list.h: the processors of [main] cpus.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <set>
#include <string>
#include <string_view>

namespace vdisp {

inline constexpr int largest_cpu = 1023;  // of what sched_setaffinity() takes in one piece

/// "0,2-3" as 0, 2, 3; blanks are allowed. Empty: not such a list.
std::optional<std::set<int>> cpu_list(std::string_view text);
/// The other way round, ranges where there are any.
std::string text_of(const std::set<int>& cpus);

}  // namespace vdisp
