// results.cpp: medians, since other work on the machine makes some runs slow and none fast.
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/results.h"

#include <algorithm>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <sstream>

namespace vdisp::bench {
namespace {

std::string number(double value, int digits, const char* unit) {
  if (value == 0) return "-";
  std::ostringstream text;
  text << std::fixed << std::setprecision(digits) << value << unit;
  return text.str();
}

std::string goal(double ratio, double ms) { return ratio > 0 ? number(ratio, 1, "x") : number(ms, 2, " ms"); }

/// aim, ok, MISSED, or nothing where nothing is asked.
std::string mark(const Result& result) {
  const Asked& asked = result.asked();
  if (asked.least_ratio > 0) return result.ratio() >= asked.aim_ratio ? "aim" : result.ratio() >= asked.least_ratio ? "ok" : "MISSED";
  if (asked.most_ms > 0) return result.ours() <= asked.aim_ms ? "aim" : result.ours() <= asked.most_ms ? "ok" : "MISSED";
  return "";
}

void row(std::ostream& out, const std::vector<std::string>& cells) {
  constexpr int widths[] = {28, 7, 10, 10, 7, 8, 8, 7};
  for (size_t i = 0; i < cells.size(); ++i)
    out << (i ? std::right : std::left) << std::setw(widths[i]) << cells[i] << (i + 1 < cells.size() ? "  " : "");
  out << '\n';
}

/// Larger images with more disparities should take no longer for each pixel and disparity.
void write_scaling(std::ostream& out, const std::vector<Result>& results) {
  double small = 0;
  for (const Result& r : results) {
    if (r.contest->pixel_disparities == 0 || r.ours() == 0 || r.threads != 1) continue;
    const double each = 1e9 * r.ours() / r.contest->pixel_disparities;
    if (r.contest->name == "matcher64") small = each;
    out << r.contest->name << ": " << std::fixed << std::setprecision(1) << each << " ps for each pixel and disparity";
    if (small > 0 && r.contest->name.starts_with("matcher128"))
      out << (each <= small ? ": ok" : ": MISSED") << ", no more than matcher64 is asked";
    out << '\n';
  }
}

}  // namespace

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double Result::ours() const { return median(ours_ms); }
double Result::peer() const { return median(peer_ms); }
double Result::ratio() const { return ours() > 0 ? peer() / ours() : 0; }

void write_table(std::ostream& out, const std::vector<Result>& results) {
  row(out, {"name", "threads", "ours ms", "peer ms", "ratio", "at least", "aim", ""});
  int reached = 0, asked = 0;
  for (const Result& r : results) {
    if (!r.skipped.empty()) {
      if (r.threads == results.front().threads) out << r.contest->name << ": skipped: " << r.skipped << '\n';
      continue;
    }
    const Asked& a = r.asked();
    const std::string word = mark(r);
    asked += !word.empty();
    reached += !word.empty() && word != "MISSED";
    row(out, {r.contest->name, std::to_string(r.threads), number(r.ours(), 3, ""), number(r.peer(), 3, ""), number(r.ratio(), 2, ""),
              goal(a.least_ratio, a.most_ms), goal(a.aim_ratio, a.aim_ms), word});
  }
  write_scaling(out, results);
  out << reached << " of " << asked << " times are at least what is asked\n";
}

void write_json(std::ostream& out, const std::vector<Result>& results) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Result& r : results) {
    if (!r.skipped.empty()) continue;
    list.push_back({{"name", r.contest->name}, {"threads", r.threads}, {"ours_ms", r.ours()}, {"peer_ms", r.peer()}, {"ratio", r.ratio()}});
  }
  out << list.dump(1) << '\n';
}

}  // namespace vdisp::bench
