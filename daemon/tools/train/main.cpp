// main.cpp: vdisp-train: the words and their options.
// SPDX-License-Identifier: Apache-2.0
#include <sysexits.h>

#include <CLI/CLI.hpp>
#include <iostream>
#include <thread>

#include "daemon/core/processor.h"
#include "daemon/geometry/calibration.h"
#include "daemon/tools/train/words.h"
#include "ipc/recording.h"

namespace vdisp::train {
namespace {

using Word = int (*)(const Options&);

void add_winnow(CLI::App* word, Chosen& chosen) {
  const auto add = [&](const char* name, auto& value, const char* help) { return word->add_option(name, value, help)->group("Network"); };
  add("--theta", chosen.theta, "Threshold of a target's activation [1]");
  add("--alpha", chosen.alpha, "Promotion, more than 1 [1.05]");
  add("--beta", chosen.beta, "Demotion, less than 1 [0.95]");
  add("--initial", chosen.initial, "Weight of a new link; 0 = theta / features of a pair [0]")->check(CLI::Range(0.0, 1e6));
  add("--passes", chosen.passes, "Passes over all pairs, at most [10]")->check(CLI::Range(1, 100000));
  add("--seed", chosen.seed, "Order of the pairs; 0 = as recorded [1]");
}

void add_thick(CLI::App* word, Chosen& chosen) {
  word->add_option("--above", chosen.above, "Thick separator: a target's own class is promoted up to theta (1 + this)")
      ->check(CLI::Range(0.0, 100.0))
      ->group("Network");
  word->add_option("--below", chosen.below, "and the other demoted down to theta (1 - this)")
      ->check(CLI::Range(0.0, 1.0))
      ->group("Network");
}

void add_common(CLI::App* word, Options& options) {
  word->add_option("--threads", options.threads, "Results do not depend on it")->check(CLI::Range(1, 64))->capture_default_str();
  word->add_flag("--json", options.json, "As JSON");
}

void add_split(CLI::App* word, Options& options) {
  auto* test = word->add_option("--test", options.test, "Recordings to judge on, instead of a part of the others")->type_name("DIR");
  word->add_option("--hold-out", options.hold_out, "Part of the recordings to hold apart, whole drives; 0 = none")
      ->check(CLI::Range(0.0, 0.9))
      ->capture_default_str()
      ->excludes(test);
  word->add_option("--split-seed", options.split_seed, "Which of them, by chance")->capture_default_str();
}

void add_front_end(CLI::App* word, Chosen& chosen) {
  const auto add = [&](const char* name, auto& value, const char* help) { return word->add_option(name, value, help)->group("Front end"); };
  add("--encoding", chosen.encoding, "What the classifiers see")->check(CLI::IsMember(encoding_names()));
  add("--smooth", chosen.smooth, "none, mean or median, 3x3")->check(CLI::IsMember({"none", "mean", "median"}));
  add("--width", chosen.disparities, "Search width, px")->check(CLI::Range(16, 256));
  add("--block", chosen.block, "Side of what is compared, px, odd")->check(CLI::Range(3, 21));
  add("--confidence", chosen.confidence, "Least confidence of a match, bits a pixel")->check(CLI::Range(0.0, 8.0));
}

void add_train(CLI::App* sub, Options& options) {
  sub->add_option("DIR", options.folders, "Labelled recordings, a folder each");
  sub->add_option("-o,--output", options.output, "Model to write, or to replace when the new one is complete")
      ->type_name("MODEL")
      ->required();
  sub->add_option("--add", options.add, "Recordings that weigh more, such as those of collisions; without DIR they join those of a model")
      ->type_name("DIR");
  sub->add_option("--add-weight", options.add_weight, "Times that each pair of them is seen in a pass")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  sub->add_option("--to", options.model, "Model whose list --add joins; without it that of -o")->type_name("MODEL");
  add_split(sub, options);
  sub->add_option("-c,--config", options.config, "vdisp.cfg whose [census] is the front end, where the next options say nothing else")
      ->type_name("FILE")
      ->group("Front end");
  add_front_end(sub, options.chosen);
  sub->add_option("--size", options.chosen.size, "Size the views are scaled to [320x240]")->type_name("WxH")->group("Front end");
  add_winnow(sub, options.chosen);
  add_thick(sub, options.chosen);
  auto* fixed = sub->add_option("--obstacle-sensitivity", options.obstacle_sensitivity,
                                "Added to free - obstacle, part of theta: less finds more obstacles [0]");
  sub->add_option("--direction-sensitivity", options.direction_sensitivity,
                  "Added to left - right, part of theta: more goes left more often [0]");
  sub->add_option("--detection", options.detection, "Choose the obstacle sensitivity that finds this part of the obstacles held apart")
      ->check(CLI::Range(1e-6, 1.0))
      ->excludes(fixed);
  sub->add_flag("--obstacle-only", options.obstacle_only, "Train no direction classifier, where labels say only that something is there");
  sub->add_flag("--compare", options.compare, "Train the other encodings too, and show them in tables and plots");
  sub->add_option("--plots", options.plots, "Write ROC plots (SVG, PNG) and their points (CSV) there")->type_name("DIR");
  add_common(sub, options);
}

void add_words(CLI::App& app, Options& options, Word& word) {
  const auto add = [&](const char* name, const char* help, Word function) {
    CLI::App* sub = app.add_subcommand(name, help);
    sub->callback([&word, function] { word = function; });
    return sub;
  };
  add_train(add("train", "Train both classifiers from labelled recordings, and judge them on recordings held apart", train), options);
  CLI::App* sub = add("evaluate", "Judge a model on recordings it has not seen", evaluate);
  sub->add_option("MODEL", options.model, "Model of vdisp-train train")->required();
  sub->add_option("DIR", options.folders, "Labelled recordings, a folder each")->required();
  sub->add_option("--plots", options.plots, "Write ROC plots (SVG, PNG) and their points (CSV) there")->type_name("DIR");
  add_common(sub, options);
  sub = add("tune", "Search front end, encoding and sensitivity for the best AUC; goes on where a search was ended", tune);
  sub->add_option("DIR", options.folders, "Labelled recordings, a folder each")->required();
  add_split(sub, options);
  Grid& grid = options.grid;
  const auto list = [&](const char* name, auto& values, const char* help) {
    return sub->add_option(name, values, help)
        ->delimiter(',')
        ->allow_extra_args(false)
        ->capture_default_str()
        ->group("What is tried, separated by commas");
  };
  list("--blocks", grid.blocks, "Block sizes, px, odd")->check(CLI::Range(3, 21));
  list("--widths", grid.widths, "Search widths, px")->check(CLI::Range(16, 256));
  list("--confidences", grid.confidences, "Confidence thresholds")->check(CLI::Range(0.0, 8.0));
  list("--smooths", grid.smooths, "Smoothing")->check(CLI::IsMember({"none", "mean", "median"}));
  list("--encodings", grid.encodings, "Encodings")->check(CLI::IsMember(encoding_names()));
  list("--thick", grid.thick, "Thick separators, both sides, part of theta")->check(CLI::Range(0.0, 1.0));
  sub->add_option("--trials", grid.trials, "Front ends at most, chosen by chance; 0 = all")->capture_default_str();
  sub->add_option("--pairs", grid.pairs, "Pairs of all recordings together, thinned evenly")
      ->check(CLI::Range(10, 100000000))
      ->capture_default_str();
  sub->add_option("--table", grid.table, "What was tried, a line each; trials in it are not made again")
      ->type_name("FILE.csv")
      ->capture_default_str();
  sub->add_option("--size", options.chosen.size, "Size the views are scaled to [320x240]")->type_name("WxH");
  add_winnow(sub, options.chosen);
  add_common(sub, options);
}

int complain(int code, const std::string& what) {
  std::cerr << "vdisp-train: " << what << std::endl;
  return code;
}

int run(int argc, char** argv) {
  CLI::App app("Trains the classifiers of the second detector, census and SNoW. vdisp-train WORD --help tells more.", "vdisp-train");
  app.set_version_flag("--version", "vdisp-train " VDISP_VERSION);
  app.require_subcommand(1);
  app.footer(
      "Exit codes: 0 done, 64 usage, 66 no input, or too little in it, 73 cannot create output, 74 output failed, 75 internal, 77 no "
      "permission, 78 a model or table is wrong.");
  Options options;
  options.threads = std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, 8);
  Word word = nullptr;
  add_words(app, options, word);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return app.exit(success);
  } catch (const CLI::ParseError& error) {
    if (app.get_subcommands().empty() && argc > 1 && argv[1][0] != '-')
      return complain(EX_USAGE, std::string("no word '") + argv[1] + "'; see vdisp-train --help");
    return complain(EX_USAGE, std::string(error.what()) + "; see vdisp-train --help");
  }
  try {
    const int code = word(options);
    return std::cout.flush() ? code : complain(EX_IOERR, "standard output cannot be written");
  } catch (const ToolError& error) {
    return complain(error.exit_code, error.what());
  } catch (const snow::ModelError& error) {
    return complain(error.exit_code, error.what());
  } catch (const RecordingError& error) {
    return complain(RecordingError::exit_code, error.what());
  } catch (const WriteError& error) {
    return complain(error.exit_code, error.what());
  } catch (const CalibrationError& error) {
    return complain(EX_CONFIG, error.what());
  } catch (const FormatError& error) {
    return complain(EX_CONFIG, error.what());
  } catch (const std::bad_alloc&) {
    return complain(EX_TEMPFAIL, "not enough memory; give fewer recordings");
  } catch (const std::exception& error) {
    return complain(EX_TEMPFAIL, std::string("internal: ") + error.what());
  }
}

}  // namespace
}  // namespace vdisp::train

int main(int argc, char** argv) { return vdisp::train::run(argc, argv); }
