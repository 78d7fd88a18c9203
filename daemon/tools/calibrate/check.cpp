// check.cpp: the word `check`: does this calibration hold on these pairs, and what is to be done where it does not.
// SPDX-License-Identifier: Apache-2.0
#include <sysexits.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "daemon/tools/calibrate/daemon_views.h"
#include "daemon/tools/calibrate/findings.h"
#include "daemon/tools/calibrate/pairs.h"
#include "daemon/tools/calibrate/taken_pairs.h"
#include "daemon/tools/calibrate/words.h"

namespace vdisp::calibrate {
namespace {

constexpr int most_ndisp = 256;
constexpr double daemon_seconds = 5;  // over which pairs of a running daemon are spread

std::string two_digits(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f", value);
  return text;
}

/// Without pairs on the command line it is the running daemon that is checked.
bool live(const Options& options) { return options.left.empty(); }

Config read(const Options& options) {
  Config config;
  const auto reading = read_config(options.config, options.sets, config);
  if (reading.exit_code != 0) {
    std::string all;
    for (const Complaint& complaint : reading.complaints)
      all +=
          (all.empty() ? "" : "; ") + complaint.file + (complaint.line ? ":" + std::to_string(complaint.line) : "") + ": " + complaint.text;
    throw ToolError(reading.exit_code, all);
  }
  config.image_source.source = "files";
  if (!live(options)) {
    config.image_source.left = images_of(options.left);
    config.image_source.right = images_of(options.right);
  }
  config.image_source.loop = false;
  config.image_source.odometry.clear();
  if (!options.calibration.empty()) config.image_source.paramfile = options.calibration;
  return config;
}

std::vector<RowMatch> match_all(const StageRun& run) {
  std::vector<RowMatch> all;
  for (const StagedPair& pair : run.pairs) {
    const auto matches = match_rows(pair.rectified[0], pair.rectified[1]);
    all.insert(all.end(), matches.begin(), matches.end());
  }
  return all;
}

/// The search that nearly all matches lie in; for who has no vdisp.cfg yet.
int fitting_ndisp(const std::vector<RowMatch>& matches, int least) {
  std::vector<double> disparities;
  for (const RowMatch& match : matches) disparities.push_back(match.disparity());
  if (disparities.empty()) return least;
  std::sort(disparities.begin(), disparities.end());
  const double most = disparities[disparities.size() * 99 / 100] * 1.1;
  return std::clamp(static_cast<int>(std::ceil(most / 16)) * 16, least, most_ndisp);
}

/// Whether the operator gave an angle: a default is nobody's word.
bool pitch_told(const Options& options) { return !options.config.empty() || !options.sets.empty(); }

/// The floor as a plane: its pitch and height are of all that is seen, without a profile.
Config measuring(const Options& options, Config config) {
  config.floor.model = "plane";
  if (!pitch_told(options)) config.mounting.pitch = config.limit.angRot = config.map.angRot = word_given;
  return config;
}

Expected expected_of(const Options& options, const Config& config) {
  return {pitch_told(options) ? config.expected_pitch() : NAN, config.mounting.height > 0 ? config.mounting.height : NAN};
}

/// The pairs in question through the stages, any number of times; the views exchanged, if asked.
using Run = std::function<StageRun(const Config&, bool exchanged)>;

Run run_of_files(const Options& options) {
  return [&options](Config config, bool exchanged) {
    if (exchanged) std::swap(config.image_source.left, config.image_source.right);
    return run_stages(open_source(config), measuring(options, config), options.most_pairs);
  };
}

/// Where the file is known that the daemon rectifies by, its raw views through that; else its rectified views.
Run run_of_daemon(const Options& options, const Config& config) {
  auto views = std::make_shared<DaemonViews>(
      look_at_daemon(options.name, options.most_pairs, options.seconds > 0 ? options.seconds : daemon_seconds));
  std::optional<Calibration> calibration;
  const std::string& file = config.image_source.paramfile;
  if (!file.empty()) try {
      calibration = read_calibration(file);
    } catch (const CalibrationError&) {
      if (!options.calibration.empty() || !options.config.empty()) throw;  // the daemon's own may be out of reach
    }
  const bool told = !options.calibration.empty() || !options.config.empty();
  const bool raw = calibration && (told || calibration->hash == views->calibration_hash);
  if (!raw) {
    calibration.reset();
    if (views->view.calibrated()) {
      calibration.emplace();
      calibration->view = views->view;
      calibration->format = "the daemon's";
    }
  }
  return [&options, views, calibration, raw](Config now, bool exchanged) {
    auto pairs = raw ? views->camera : views->rectified;
    if (!raw) now.image_source.bayer = "none";
    if (exchanged)
      for (auto& pair : pairs) std::swap(pair[0], pair[1]);
    StageRun run = run_stages(std::make_unique<TakenPairs>(std::move(pairs), calibration), measuring(options, now), options.most_pairs);
    run.bad += views->blind;
    return run;
  };
}

/// Views that are exchanged are rectified wrongly as well, which may hide that they are: their rows agree better the other way round.
bool exchanged(const Run& run, const Config& config, const StereoView& view, double rows, Findings& findings) {
  const auto matches = match_all(run(config, true));
  if (matches.size() < fewest_matches) return false;
  const double other = fit_misalignment(matches, view).median_px;
  if (other > rows / 2) return false;
  findings.push_back(exchanged_views("rows differ by " + two_digits(rows) + " px as they are given, and by " + two_digits(other) +
                                     " the other way round"));
  return true;
}

double value_of(const Findings& findings, const std::string& name) {
  for (const Finding& finding : findings)
    if (finding.name == name) return finding.value;
  return NAN;
}

int print(const Options& options, const Findings& findings, const StageRun& run) {
  const auto is = [](Verdict verdict) { return [verdict](const Finding& finding) { return finding.verdict == verdict; }; };
  const auto faults = std::count_if(findings.begin(), findings.end(), is(Verdict::fault));
  const bool rows =
      std::any_of(findings.begin(), findings.end(), [](const Finding& f) { return f.name == "rows" && f.verdict != Verdict::unknown; });
  const char* words[] = {"fine", "FAULT", "doubt", "unknown", ""};
  if (options.json) {
    nlohmann::json out{{"pairs", run.pairs.size()}, {"bad_pairs", run.bad}, {"faults", faults}, {"fine", faults == 0 && rows}};
    for (const Finding& f : findings) {
      out["findings"].push_back({{"name", f.name},
                                 {"verdict", f.verdict == Verdict::fact ? "fact" : words[static_cast<int>(f.verdict)]},
                                 {"text", f.text},
                                 {"fix", f.fix}});
      if (std::isfinite(f.value)) out["findings"].back()["value"] = f.value;
    }
    std::cout << out.dump(2) << '\n';
  } else {
    for (const Finding& f : findings) {
      std::string word = words[static_cast<int>(f.verdict)];
      word.resize(9, ' ');
      std::cout << word << f.text << '\n';
      if (!f.fix.empty()) std::cout << "         -> " << f.fix << '\n';
    }
    std::cout << run.pairs.size() << " pairs" << (run.bad ? ", " + std::to_string(run.bad) + " bad ones left out" : "") << ": "
              << (faults ? std::to_string(faults) + (faults == 1 ? " fault" : " faults")
                  : rows ? "fine"
                         : "not to be told")
              << '\n';
  }
  return faults ? EX_CONFIG : rows ? EX_OK : EX_NOINPUT;
}

}  // namespace

int check(const Options& given) {
  Options options = given;
  if (live(options) && options.config.empty()) {  // what it is set to, and over that what the operator says
    options.sets = settings_of_daemon();
    options.sets.insert(options.sets.end(), given.sets.begin(), given.sets.end());
  }
  Config config = read(options);
  if (!live(options) && config.image_source.paramfile.empty() && options.board.size.size())
    throw ToolError(EX_USAGE, "--board without a calibration; needed is --calibration FILE, or a vdisp.cfg with paramfile");
  std::optional<Board> board;
  if (!options.board.size.empty()) board.emplace(options.board);
  const Run again = live(options) ? run_of_daemon(options, config) : run_of_files(options);
  StageRun run = again(config, false);
  if (run.pairs.empty())
    throw ToolError(EX_NOINPUT,
                    live(options) ? "none of the daemon's pairs is good" : "no pair of " + config.image_source.left + " is good");
  const cv::Size size = run.pairs[0].rectified[0].size();
  const bool calibrated = run.calibration.has_value();
  // Without a calibration rows can be compared all the same; angles then are as of a usual lens.
  const StereoView view = calibrated ? run.calibration->view : StereoView{1.0 * size.width, size.width / 2.0, size.height / 2.0, 0, 0};
  const std::vector<RowMatch> matches = match_all(run);

  Findings findings;
  const double rows = matches.size() < fewest_matches ? 0 : fit_misalignment(matches, view).median_px;
  const bool suspicious = rows > most_row_error && calibrated && run.calibration->raw;
  if (!(suspicious && exchanged(again, config, view, rows, findings)) && find_order(run, matches, view, findings)) {
    find_misalignment(matches, view, size, calibrated, findings);
    if (options.config.empty() && calibrated) {
      const int wanted = fitting_ndisp(matches, config.image_source.ndisp);
      if (wanted > config.image_source.ndisp) {
        config.image_source.ndisp = wanted;
        run = again(config, false);
      }
    }
    if (calibrated) {
      const double scale = board ? find_scale(run, *board, view, findings) : NAN;
      find_mounting(run, expected_of(options, config), scale, view, findings);
      find_abilities(run, config, value_of(findings, "pitch"), value_of(findings, "height"), findings);
    } else {
      findings.push_back({"metres", Verdict::unknown, "no calibration: pitch, height and ranges are not known",
                          "--calibration FILE, or a vdisp.cfg with paramfile", NAN});
    }
  }
  return print(options, findings, run);
}

}  // namespace vdisp::calibrate
