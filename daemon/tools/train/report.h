// report.h: what a judgement comes to: confusion, ROC points, area; as text, JSON, CSV.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "daemon/tools/train/plot.h"
#include "daemon/tools/train/trainer.h"

namespace vdisp::train {

/// One classifier on what was held apart.
struct Verdict {
  bool direction = false;
  double sensitivity = 0;
  snow::Confusion confusion;  ///< positives: obstacle, or left
  std::vector<snow::RocPoint> curve;
  double auc = 0;  ///< NaN: a class is missing
  bool judged() const { return !curve.empty(); }
};
Verdict obstacle_verdict(const Judgement& judgement, double sensitivity);
Verdict direction_verdict(const Judgement& judgement, double sensitivity);

/// The sensitivity with which the curve's point is decided: that an obstacle with this score is one, or that it is left.
double obstacle_sensitivity_of(const snow::RocPoint& point);
double direction_sensitivity_of(const snow::RocPoint& point);

/// snow::Trained::clear of the obstacle classifier: the median difference of the free pairs that look more free than blocked; 1 where none
/// does. The median, as a few of the clearest would make all others slow; whatever the sensitivity, as who is careful is not to be faster.
double clear_of(const Judgement& judgement);

/// For people: lines of text. Where a class is missing they say which.
std::string text_of(const Verdict& verdict);
/// The curve is thinned to what a plot can show.
nlohmann::json json_of(const Verdict& verdict);
/// Header: encoding,classifier,threshold,false_acceptance,detection.
std::string csv_of(const std::string& encoding, const Verdict& verdict);

/// The verdicts of one encoding.
struct Judged {
  std::string encoding;
  Verdict obstacle, direction;
};
/// Figures 11 to 13 as SVG and PNG, points as CSV: roc.*, obstacle.*, direction.*, points.csv in the folder, which is created. The
/// first is what roc shows. A figure without a curve is left out. Throws WriteError.
void write_plots(const std::string& folder, const std::vector<Judged>& judged);

}  // namespace vdisp::train
