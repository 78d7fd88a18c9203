// main.cpp: vdisp-calibrate: the words and their options.
// SPDX-License-Identifier: Apache-2.0
#include <sysexits.h>

#include <CLI/CLI.hpp>
#include <iostream>
#include <opencv2/core/utility.hpp>
#include <opencv2/core/utils/logger.hpp>

#include "daemon/sources/source.h"
#include "daemon/tools/calibrate/words.h"
#include "ipc/png.h"

namespace vdisp::calibrate {
namespace {

using Word = int (*)(const Options&);

void add_reading(CLI::App* word, Options& options) {
  word->add_flag("--colour", options.reading.colour, "KITTI: the colour cameras 2 and 3 instead of 0 and 1");
  word->add_flag("--unrectified", options.reading.unrectified, "KITTI calib_cam_to_cam, SVS: of the images before they were rectified");
}

void add_board(CLI::App* word, BoardOptions& board, bool needed) {
  auto* size =
      word->add_option("--board", board.size, "Chessboard: inner corners across and down, as 9x6; ChArUco: squares")->type_name("NxM");
  auto* square = word->add_option("--square", board.square_m, "Side of a square, m")->type_name("M")->check(CLI::Range(1e-4, 10.0));
  word->add_option("--kind", board.kind, "chessboard or charuco")->check(CLI::IsMember({"chessboard", "charuco"}))->capture_default_str();
  word->add_option("--marker", board.marker_m, "ChArUco: side of a marker, m; 0 = three quarters of a square")
      ->type_name("M")
      ->check(CLI::Range(0.0, 10.0));
  word->add_option("--dictionary", board.dictionary, "ChArUco: OpenCV's name of the markers' dictionary")->capture_default_str();
  size->needs(square);
  square->needs(size);
  if (needed) size->required(), square->required();
}

/// `required`: else both or none.
void add_pairs(CLI::App* word, Options& options, bool required) {
  auto* left = word->add_option("LEFT", options.left, "Left images: a folder, a pattern (left/%06d.png) or a glob in quotes");
  auto* right = word->add_option("RIGHT", options.right, "Right images, in the same form");
  if (required) left->required(), right->required();
  left->needs(right);
}

void add_name(CLI::App* word, Options& options) {
  word->add_option("-n,--name", options.name, "Name of the daemon's images ([main] name)")->capture_default_str();
}

void add_words(CLI::App& app, Options& options, Word& word) {
  const auto add = [&](const char* name, const char* help, Word function) {
    CLI::App* sub = app.add_subcommand(name, help);
    sub->callback([&word, function] { word = function; });
    return sub;
  };
  CLI::App* sub = add("show", "What a calibration file says", show);
  sub->add_option("FILE", options.input, "Calibration of any known format, or the folder of a pair")->required();
  sub->add_flag("--json", options.json, "As JSON");
  add_reading(sub, options);
  sub = add("convert", "Write a calibration in another format", convert);
  sub->add_option("IN", options.input, "Calibration of any known format, or the folder of a pair")->required();
  sub->add_option("OUT", options.output, "File, or for ros the folder of left.yaml and right.yaml")->required();
  sub->add_option("--format", options.format, "svs, opencv or ros; without it by OUT's ending: .ini, .yml or .yaml, none")
      ->check(CLI::IsMember({"svs", "opencv", "ros"}));
  sub->add_option("--size", options.size, "Size of the images, where IN does not know it")->type_name("WxH");
  add_reading(sub, options);
  sub = add("solve", "Calibrate from pairs of images of a board", solve);
  add_pairs(sub, options, true);
  add_board(sub, options.board, true);
  sub->add_option("-o,--output", options.output, "Calibration to write")->type_name("FILE");
  sub->add_option("--format", options.format, "svs, opencv or ros; without it by the ending")
      ->check(CLI::IsMember({"svs", "opencv", "ros"}));
  sub->add_option("--report", options.report, "Picture of coverage and errors to write")->type_name("FILE.png");
  sub->add_option("--most-rms", options.most_rms, "Greatest reprojection error of a result that is usable, px")
      ->check(CLI::Range(0.01, 10.0))
      ->capture_default_str();
  sub->add_flag("--json", options.json, "As JSON");
  sub = add("check", "Measure on pairs of images, or without any on the running daemon's, whether a calibration holds, and say what to do",
            check);
  add_pairs(sub, options, false);
  sub->add_option("--calibration", options.calibration, "Calibration to check; without it [image source] paramfile")->type_name("FILE");
  sub->add_option("-c,--config", options.config, "vdisp.cfg to compare pitch and height with")->type_name("FILE");
  sub->add_option("--set", options.sets, "Override one parameter; may be repeated")
      ->type_name("SECTION.KEY=VALUE")
      ->allow_extra_args(false);
  sub->add_option("--pairs", options.most_pairs, "Look at so many pairs, from the first on")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  sub->add_option("--seconds", options.seconds, "Running daemon: take the pairs over so long; 0 = 5")
      ->check(CLI::Range(0.0, 600.0))
      ->capture_default_str();
  add_name(sub, options);
  add_board(sub, options.board, false);
  sub->add_flag("--json", options.json, "As JSON");
  sub = add("capture", "Take views of a board from the running daemon, those that are worth it", capture);
  sub->add_option("DIR", options.output, "Folder; views become DIR/left/000000.png, DIR/right/000000.png, ...")->required();
  add_board(sub, options.board, true);
  sub->add_option("--views", options.views, "Views to take")->check(CLI::Range(5, 1000))->capture_default_str();
  sub->add_flag("--window", options.window,
                "Show the views, the board found and what is missing in a window: space takes a view, u takes the last one back, q ends");
  sub->add_option("--seconds", options.seconds, "End after so long; 0 = when all is taken, or at Ctrl-C")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  add_name(sub, options);
}

int complain(int code, const std::string& what) {
  std::cerr << "vdisp-calibrate: " << what << std::endl;
  return code;
}

int run(int argc, char** argv) {
  CLI::App app("Calibrates stereo cameras; shows, converts and checks calibrations. vdisp-calibrate WORD --help tells more.",
               "vdisp-calibrate");
  app.set_version_flag("--version", "vdisp-calibrate " VDISP_VERSION);
  app.require_subcommand(1);
  app.footer(
      "Exit codes: 0 done, and of check: nothing wrong; 64 usage, 66 no input, or too little in it, 69 no daemon, 71 no shared memory, 73 "
      "cannot create output,\n"
      "74 output failed, 75 internal, 77 no permission, 78 the calibration, or what it is compared with, is wrong.");
  Options options;
  Word word = nullptr;
  add_words(app, options, word);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return app.exit(success);
  } catch (const CLI::ParseError& error) {
    if (app.get_subcommands().empty() && argc > 1 && argv[1][0] != '-')
      return complain(EX_USAGE, std::string("no word '") + argv[1] + "'; see vdisp-calibrate --help");
    return complain(EX_USAGE, std::string(error.what()) + "; see vdisp-calibrate --help");
  }
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  cv::redirectError([](int, const char*, const char*, const char*, int, void*) { return 0; });  // they are thrown too
  try {
    const int code = word(options);
    return std::cout.flush() ? code : complain(EX_IOERR, "standard output cannot be written");
  } catch (const ToolError& error) {
    return complain(error.exit_code, error.what());
  } catch (const SourceError& error) {
    return complain(error.exit_code, error.what());
  } catch (const WriteError& error) {
    return complain(error.exit_code, error.what());
  } catch (const CalibrationError& error) {
    return complain(EX_CONFIG, error.what());
  } catch (const FormatError& error) {
    return complain(EX_CONFIG, error.what());
  } catch (const std::exception& error) {
    return complain(EX_TEMPFAIL, std::string("internal: ") + error.what());
  }
}

}  // namespace
}  // namespace vdisp::calibrate

int main(int argc, char** argv) { return vdisp::calibrate::run(argc, argv); }
