// report.cpp: tables of a judgement.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/tools/train/report.h"

#include <sysexits.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "ipc/png.h"

namespace vdisp::train {
namespace {

constexpr size_t plotted = 400;  // points of a curve: more than a plot has px
constexpr double told[] = {0.5, 0.8, 0.9, 0.95, 0.98, 0.99, 0.995, 0.999, 1};

__attribute__((format(printf, 1, 2))) std::string print(const char* format, ...) {
  std::array<char, 300> line;
  va_list values;
  va_start(values, format);
  std::vsnprintf(line.data(), line.size(), format, values);
  va_end(values);
  return line.data();
}

/// Corners that a plot would show: those a pixel or so apart.
std::vector<snow::RocPoint> thinned(const std::vector<snow::RocPoint>& curve) {
  std::vector<snow::RocPoint> kept;
  for (const snow::RocPoint& point : curve) {
    const double step = kept.empty() ? 1 : point.false_rate - kept.back().false_rate + point.true_rate - kept.back().true_rate;
    if (step * plotted >= 1 || &point == &curve.back()) kept.push_back(point);
  }
  return kept;
}

Verdict verdict_of(bool direction, const std::vector<snow::Judged>& judged, double sensitivity, double threshold) {
  return {direction, sensitivity, snow::confusion(judged, threshold), snow::roc_curve(judged), snow::area_under_curve(judged)};
}

double sensitivity_of(const Verdict& verdict, const snow::RocPoint& point) {
  return verdict.direction ? direction_sensitivity_of(point) : obstacle_sensitivity_of(point);
}

}  // namespace

// An obstacle is decided where difference + sensitivity <= 0: where the score, which is - difference, is at least the sensitivity.
Verdict obstacle_verdict(const Judgement& judgement, double sensitivity) {
  return verdict_of(false, judgement.obstacle, sensitivity, sensitivity);
}
double obstacle_sensitivity_of(const snow::RocPoint& point) { return point.threshold; }

double clear_of(const Judgement& judgement) {
  std::vector<double> free;
  for (const snow::Judged& one : judgement.obstacle)
    if (!one.positive && one.score < 0) free.push_back(-one.score);
  if (free.empty()) return 1;
  const auto middle = free.begin() + static_cast<std::ptrdiff_t>(free.size() / 2);
  std::nth_element(free.begin(), middle, free.end());
  return *middle;
}

// Left is decided where difference + sensitivity > 0: where the score is more than - sensitivity.
Verdict direction_verdict(const Judgement& judgement, double sensitivity) {
  return verdict_of(true, judgement.direction, sensitivity, std::nextafter(-sensitivity, std::numeric_limits<double>::infinity()));
}
double direction_sensitivity_of(const snow::RocPoint& point) {
  return -std::nextafter(point.threshold, -std::numeric_limits<double>::infinity());
}

std::string text_of(const Verdict& v) {
  const char* const positive = v.direction ? "left" : "obstacle";
  const char* const negative = v.direction ? "right" : "free";
  const char* const title = v.direction ? "direction" : "obstacle";
  if (!v.judged())
    return print("%s: not judged: no pair of class %s\n", title,
                 v.confusion.positives()   ? negative
                 : v.confusion.negatives() ? positive
                                           : "left or right");
  std::string text = print("%s: AUC %.4f of %zu %s and %zu %s pairs held apart\n", title, v.auc, v.confusion.positives(), positive,
                           v.confusion.negatives(), negative);
  text += print("  with sensitivity %g: %.2f %% right\n", v.sensitivity, 100 * v.confusion.accuracy());
  text += print("  %12s %12s %12s\n", "", (std::string("says ") + positive).c_str(), (std::string("says ") + negative).c_str());
  text += print("  %12s %12zu %12zu\n", positive, v.confusion.hits, v.confusion.misses);
  text += print("  %12s %12zu %12zu\n", negative, v.confusion.false_alarms, v.confusion.rejections);
  text += print("  %12s %12s %12s\n", "detection", "false accept", "sensitivity");
  for (const double rate : told) {
    const snow::RocPoint point = snow::point_of_detection(v.curve, rate);
    text += print("  %12.4f %12.4f %12.5f\n", point.true_rate, point.false_rate, sensitivity_of(v, point));
  }
  return text;
}

nlohmann::json json_of(const Verdict& v) {
  nlohmann::json json{{"judged", v.judged()},
                      {"sensitivity", v.sensitivity},
                      {"positive", v.direction ? "left" : "obstacle"},
                      {"negative", v.direction ? "right" : "free"},
                      {"confusion",
                       {{"hits", v.confusion.hits},
                        {"misses", v.confusion.misses},
                        {"false_alarms", v.confusion.false_alarms},
                        {"rejections", v.confusion.rejections}}}};
  if (!v.judged()) return json;
  json["auc"] = v.auc;
  auto& roc = json["roc"] = nlohmann::json::array();
  for (const snow::RocPoint& point : thinned(v.curve)) {
    const bool first = std::isinf(point.threshold);
    roc.push_back({{"threshold", first ? nlohmann::json() : nlohmann::json(point.threshold)},
                   {"false_acceptance", point.false_rate},
                   {"detection", point.true_rate}});
  }
  return json;
}

std::string csv_of(const std::string& encoding, const Verdict& v) {
  std::string text;
  for (const snow::RocPoint& point : v.curve)
    text += print("%s,%s,%.9g,%.9g,%.9g\n", encoding.c_str(), v.direction ? "direction" : "obstacle", point.threshold, point.false_rate,
                  point.true_rate);
  return text;
}

void write_plots(const std::string& folder, const std::vector<Judged>& all) {
  const std::filesystem::path place(folder);
  std::error_code error;
  std::filesystem::create_directories(place, error);
  if (error) throw WriteError(EX_CANTCREAT, folder + ": cannot be created: " + error.message());
  const auto curve = [](const Judged& one, const Verdict& verdict) {
    Curve drawn{one.encoding + print(" (%.4f)", verdict.auc), {}};
    for (const snow::RocPoint& point : thinned(verdict.curve)) drawn.points.push_back({point.false_rate, point.true_rate});
    return drawn;
  };
  const auto write = [&](const char* name, const Plot& plot) {
    if (plot.curves.empty()) return;
    write_file(place / (std::string(name) + ".svg"), svg_of(plot));
    write_file(place / (std::string(name) + ".png"), png_of(plot));
  };
  Plot one{"ROC of the obstacle classifier", "1 - Specificity", "Sensitivity", {}, true};
  Plot obstacle{"ROC of the obstacle classifier", "False acceptance rate (FAR)", "Detection rate (DET)", {}, false};
  Plot direction{"ROC of the direction classifier", obstacle.x, obstacle.y, {}, false};
  std::string points = "encoding,classifier,threshold,false_acceptance,detection\n";
  for (const Judged& judged : all) {
    if (judged.obstacle.judged()) obstacle.curves.push_back(curve(judged, judged.obstacle));
    if (judged.direction.judged()) direction.curves.push_back(curve(judged, judged.direction));
    points += csv_of(judged.encoding, judged.obstacle) + csv_of(judged.encoding, judged.direction);
  }
  if (!all.empty() && all.front().obstacle.judged()) one.curves.push_back(curve(all.front(), all.front().obstacle));
  write("roc", one);
  write("obstacle", obstacle);
  write("direction", direction);
  write_file(place / "points.csv", points);
}

}  // namespace vdisp::train
