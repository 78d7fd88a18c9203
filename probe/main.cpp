// main.cpp: vdisp-probe: the words and their options.
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <iostream>
#include <new>

#include "ipc/png.h"
#include "probe/attach.h"
#include "probe/words.h"

namespace vdisp {
namespace {

/// How a word finds a daemon: by the name of its images, by an argument of its own or the control socket, or not at all.
enum class Reach { images, other, nobody };

void add_words(CLI::App& app, Options& options, int (*&word)(const Options&)) {
  const auto add = [&](const char* name, const char* help, int (*function)(const Options&), Reach reach = Reach::images) {
    CLI::App* sub = app.add_subcommand(name, help);
    sub->callback([&word, function] { word = function; });
    if (reach == Reach::images)
      sub->add_option("-n,--name", options.name, "Name of the daemon's images ([main] name)")->capture_default_str();
    if (reach != Reach::nobody)
      sub->add_option("--wait", options.wait_s, "Wait up to this many seconds for a daemon")
          ->check(CLI::Range(0.0, 1e6))
          ->type_name("SECONDS");
    return sub;
  };
  CLI::App* sub = add("view", "Page through the stages in a window: arrow keys, ? for help", view, Reach::other);
  sub->add_option("NAME", options.name, "Name of the daemon's images ([main] name)")->capture_default_str();
  sub->add_option("--stage", options.topics, "Stage to begin with")->expected(1)->type_name("TOPIC");
  const auto add_drive = [&](CLI::App* word_app) {
    word_app->add_option("--speed", options.speed, "Speed of an order ahead")
        ->check(CLI::Range(0.01, 10.0))
        ->type_name("M/S")
        ->capture_default_str();
    word_app->add_option("--turn", options.turn, "Turn rate of an order to turn")
        ->check(CLI::Range(0.01, 10.0))
        ->type_name("RAD/S")
        ->capture_default_str();
    word_app
        ->add_option("--control", options.control,
                     "The daemon's control socket ([control] socket), also for the sliders; without it the usual places")
        ->type_name("PATH");
  };
  sub->add_flag("--drive", options.drive, "Drive by hand: arrow keys, mouse buttons or a gamepad; ? for help");
  add_drive(sub);
  sub = add("list", "The stages as a tree: format, readers, runs, time", list);
  sub->add_flag("--json", options.json, "As JSON");
  sub = add("dump", "Write the images of whole frames to a folder, in the format of vdispd --dump", dump);
  sub->add_option("DIR", options.output, "Folder; frames become DIR/000000, DIR/000001, ...")->required();
  sub->add_option("TOPIC", options.topics, "Stages; none: all");
  CLI::Option* frames =
      sub->add_option("--frames", options.frames, "Frames to write")->check(CLI::Range(1, 1000000))->capture_default_str();
  sub->add_flag("--once", options.once, "One frame")->excludes(frames);
  sub->add_flag("--picture", options.picture, "Also as view shows them: STAGE_view.png");
  sub = add("map", "The map, live in the terminal; q ends", map);
  sub->add_flag("--once", options.once, "Print one map and end");
  sub->add_flag("--json", options.json, "As JSON, one line for each map");
  sub->add_option("--stage", options.topics, "Another map, such as truth/map")->expected(1)->type_name("TOPIC");
  sub = add("stats", "Times, runs and drops of the stages, each second", stats);
  sub->add_flag("--once", options.once, "Print once and end");
  sub->add_flag("--json", options.json, "As JSON, one line a second");
  sub = add("latency", "From the exposure to the map: p50, p99, p99.9, longest, and the histogram", latency);
  sub->add_option("--seconds", options.seconds, "Measure so long; without it all since the daemon's start")
      ->check(CLI::Range(0.1, 1e6))
      ->type_name("S");
  sub->add_flag("--reader", options.reader, "In the hands of a reader of the map (10 s without --seconds)");
  sub->add_flag("--json", options.json, "As JSON, one line");
  sub = add("why", "Why a cell of the map, or a pixel, is what it is: back to disparities, floor and thresholds", why);
  sub->add_option("ROW", options.row, "Row from 0: of a map's cells row 0 is farthest")->required()->check(CLI::Range(0, 65535));
  sub->add_option("COLUMN", options.column, "Column from 0, from the left")->required()->check(CLI::Range(0, 65535));
  CLI::Option* pixel = sub->add_flag("--pixel", options.pixel, "A pixel of the left view");
  sub->add_flag("--cell")->description("A cell of the map, as without it")->excludes(pixel);
  sub->add_option("--control", options.control,
                  "With --pixel: the daemon's control socket ([control] socket), which knows the limits; without it the usual places")
      ->type_name("PATH");
  sub->add_flag("--json", options.json, "As JSON, one line");
  sub = add("record", "Record pairs, labels and what comes in to a folder; source = files or replay shows it again", record);
  sub->add_option("DIR", options.output, "Folder to write; it must not hold a recording")->required();
  sub->add_option("--rate", options.rate, "Pairs a second; without it every frame, and the stages begin anew with the recording")
      ->check(CLI::Range(0.001, 1000.0))
      ->type_name("HZ");
  sub->add_option("--seconds", options.seconds, "How long; without it until it is stopped")->check(CLI::Range(0.001, 1e7))->type_name("S");
  sub->add_flag("--running", options.running, "Let the stages remember what came before; a replay does not");
  sub->add_flag("--view", options.window, "In the window, driven by hand: arrow keys, mouse buttons or a gamepad");
  sub->add_flag("--json", options.json, "As JSON");
  add_drive(sub);
  sub = add("replay", "Run vdispd on a recording, with the configuration it was made with", replay, Reach::nobody);
  sub->add_option("DIR", options.output, "Folder of the recording")->required();
  sub->add_option("OPTION", options.topics, "Options for vdispd, behind --");
  sub = add("dump-flight", "Write what the flight recorder holds to a folder, and tell its name", dump_flight);
  sub->add_option("--control", options.control, "The daemon's control socket ([control] socket); without it the usual places")
      ->type_name("PATH");
  sub->add_flag("--json", options.json, "As JSON");
  const auto add_control = [&](const char* name, const char* help, int (*function)(const Options&)) {
    CLI::App* word_app = add(name, help, function, Reach::other);
    word_app->add_option("--control", options.control, "The daemon's control socket ([control] socket); without it the usual places")
        ->type_name("PATH");
    word_app->add_flag("--json", options.json, "As JSON");
    return word_app;
  };
  sub = add_control("set", "Set a parameter of the running daemon; it takes effect between two frames", set);
  sub->add_option("KEY", options.key, "SECTION.KEY, or KEY where one section has it")->required();
  sub->add_option("VALUE", options.value, "As in vdisp.cfg")->required();
  sub = add_control("get", "A parameter of the running daemon: value, default, range, help; without KEY all values", get);
  sub->add_option("KEY", options.key, "SECTION.KEY, or KEY where one section has it");
  sub = add("compare", "Old and new beside each other on the same frame, before a parameter is set", compare);
  sub->add_option("KEY=VALUE", options.sets, "Parameters behind the rectified pair, live or not")->required();
  sub->add_option("-o,--output", options.output, "PNG file instead of a window")->type_name("FILE");
  sub->add_option("--stage", options.topics, "Stage to show; may be repeated")->type_name("TOPIC")->allow_extra_args(false);
  sub->add_option("--frames", options.frames, "Pairs to take, so that what looks back has something to look at; the last one is shown")
      ->check(CLI::Range(1, 60))
      ->capture_default_str();
  sub->add_option("--control", options.control, "The daemon's control socket ([control] socket); without it the usual places")
      ->type_name("PATH");
  sub->add_flag("--json", options.json, "How much each stage differs, as JSON");
  add_control("save", "Write what was set into the vdisp.cfg that the daemon was started with", save);
  add_control("undo", "Take the last set back", undo);
  sub = add_control("send", "Send odometry, IMU samples, drive orders or events to the daemon, from CSV lines", send);
  sub->add_option("KIND", options.key, "odometry, imu, drive or event")
      ->required()
      ->check(CLI::IsMember({"odometry", "imu", "drive", "event"}));
  sub->add_option("LABEL", options.value, "event: the label; one event is sent at once");
  sub->add_option("--file", options.input, "CSV, its first line may name the columns; without it standard input")->type_name("FILE");
  sub->add_option("--rate", options.rate, "Lines a second; without it as timestamp_ns tells, or as they come")
      ->check(CLI::Range(0.001, 100000.0))
      ->type_name("HZ");
  sub = add("sheet", "All stages of one frame in one PNG file", sheet);
  sub->add_option("FILE", options.output, "PNG file to write")->required();
}

}  // namespace

int run(int argc, char** argv) {
  CLI::App app("vdisp-probe looks at what vdispd publishes. vdisp-probe WORD --help tells more.", "vdisp-probe");
  app.set_version_flag("--version", "vdisp-probe " VDISP_VERSION);
  app.require_subcommand(1);
  Options options;
  int (*word)(const Options&) = nullptr;
  add_words(app, options, word);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return app.exit(success);
  } catch (const CLI::ParseError& error) {
    const bool no_word = app.get_subcommands().empty();
    if (no_word && argc > 1)
      std::cerr << "vdisp-probe: no word '" << argv[1] << "'; see vdisp-probe --help\n";
    else
      std::cerr << "vdisp-probe: " << error.what() << "; see vdisp-probe --help\n";
    return 64;
  }
  try {
    return word == record && options.window ? view(options) : word(options);
  } catch (const ProbeError& error) {
    if (error.exit_code == 69 && stopped()) return 0;  // told to stop while it looked for the daemon
    std::cerr << "vdisp-probe: " << error.what() << "\n";
    return error.exit_code;
  } catch (const WriteError& error) {
    std::cerr << "vdisp-probe: " << error.what() << "\n";
    return error.exit_code;
  }
}

}  // namespace vdisp

int main(int argc, char** argv) {
  try {
    return vdisp::run(argc, argv);
  } catch (const std::bad_alloc&) {
    std::cerr << "vdisp-probe: not enough memory for what was asked; free some, or raise its limit (ulimit -v, MemoryMax)\n";
    return 71;
  }
}
