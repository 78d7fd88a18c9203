// options.cpp: CLI11 reads the words, config/ the file.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/options.h"

#include <sysexits.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <filesystem>
#include <iostream>
#include <sstream>

#include "daemon/kernels/kernels.h"
#include "daemon/recorder.h"
#include "daemon/tree.h"
#include "ipc/shm.h"

namespace vdisp {
namespace {

constexpr const char* installed_config = "/etc/vdisp/vdisp.cfg";

std::string whole_number(const std::string& text) {
  uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool good = error == std::errc() && end == text.data() + text.size() && value > 0;
  return good ? "" : "'" + text + "' must be a whole number from 1";
}

std::string not_empty(const std::string& text) { return text.empty() ? "is empty; needed is a path" : ""; }

std::string instruction_sets() {
  std::string names;
  for (const std::string& level : kernels::levels()) names += (names.empty() ? "" : ", ") + level;
  return names;
}

std::string known_instruction_set(const std::string& level) {
  try {
    kernels::kernels(level);
  } catch (const std::invalid_argument& unknown) {
    return unknown.what();
  }
  return "";
}

/// What the pools of the shared memory will hold, as comments, where the source can be opened here.
void print_memory(std::ostream& out, const Config& config) {
  try {
    Machine machine;
    Driver driver(0);
    Inputs inputs(config);
    Recorder recorder;
    build_tree(driver, open_source(config), machine, config, inputs);
    recorder.add_report(driver);
    TopicList topics;
    for (const Topic& topic : driver.published_topics()) topics.emplace_back(topic.name, topic.spec);
    std::ostringstream pools;
    print_pools(pools, topics);
    out << "\n# Shared memory of this tree:\n";
    std::istringstream lines(pools.str());
    for (std::string line; std::getline(lines, line);) out << "# " << line << '\n';
  } catch (const std::exception& error) {
    out << "\n# Shared memory: not known, for the source cannot be opened: " << error.what() << '\n';
  }
}

/// 0, or the exit code after all complaints have been said.
int read(const std::string& file, std::vector<std::string> sets, bool sim, Options& options) {
  if (sim) sets.push_back("image source.source=sim");
  std::error_code ignored;
  const bool installed = file.empty() && std::filesystem::exists(installed_config, ignored);
  options.file = installed ? installed_config : file;
  options.sets = std::move(sets);
  const ConfigReading reading = read_config(options.file, options.sets, options.config);
  for (const Complaint& note : reading.notes) std::cerr << "vdispd: " << note << '\n';
  for (const Complaint& complaint : reading.complaints) std::cerr << complaint << '\n';
  return reading.exit_code;
}

}  // namespace

Parsed parse_options(int argc, char** argv) {
  Parsed parsed;
  Options& options = parsed.options;
  std::string file;
  std::vector<std::string> sets;
  bool sim = false, check_only = false, print = false;

  CLI::App app("Turns stereo frames into an obstacle map, and shows every stage of the way in shared memory.", "vdispd");
  app.set_version_flag("--version", "vdispd " VDISP_VERSION "\ninstruction sets here: " + instruction_sets());
  app.add_option("-c,--config", file, "Configuration; without it /etc/vdisp/vdisp.cfg, or the defaults where that does not exist")
      ->type_name("FILE");
  app.add_flag("--sim", sim, "Show a simulated world instead of a camera's (source = sim)");
  app.add_option("--set", sets, "Override one parameter; may be repeated")->type_name("SECTION.KEY=VALUE")->allow_extra_args(false);
  app.add_option("--frames", options.frames, "End after N frames, blind ones counted")->type_name("N")->check(whole_number);
  app.add_option("--dump", options.dump, "Compute all stages and write each frame to DIR/000000, DIR/000001, ...")
      ->type_name("DIR")
      ->check(not_empty);
  app.add_option("--record", options.record,
                 "Record every step to the folder DIR: pairs with labels, and what came in; source = files replays it")
      ->type_name("DIR")
      ->check(not_empty);
  app.add_flag("--images", options.images, "With --dump: also each image as it is in memory, STAGE.image")->needs(app.get_option("--dump"));
  app.add_option("--cpu", options.cpu, "Instruction set of the kernels, here " + instruction_sets() + "; auto is the last of them")
      ->type_name("LEVEL")
      ->check(known_instruction_set);
  app.add_flag("--check-config", check_only, "Say all that is wrong with the configuration and end");
  app.add_flag("--print-config", print, "Print the configuration as it is understood and end");
  app.add_option("--dot", options.dot, "Write the processing tree as a Graphviz graph to FILE")->type_name("FILE")->check(not_empty);
  app.footer(
      "Exit codes: 0 done, 64 usage, 66 no input, 69 no camera or another daemon runs, 71 no shared memory,\n"
      "73 cannot create output, 74 output failed, 75 internal, 77 no permission, 78 wrong configuration.");
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& done) {
    parsed.exit_code = app.exit(done);
    return parsed;
  } catch (const CLI::ParseError& error) {
    std::cerr << "vdispd: " << error.what() << "; see vdispd --help\n";
    parsed.exit_code = EX_USAGE;
    return parsed;
  }

  const int exit_code = read(file, sets, sim, options);
  if (exit_code != 0 || check_only || print) parsed.exit_code = exit_code;
  if (exit_code == 0 && check_only) std::cout << (file.empty() ? "the configuration" : file) << ": nothing wrong\n";
  if (exit_code == 0 && print) {
    print_config(std::cout, options.config);
    print_memory(std::cout, options.config);
  }
  if (!std::cout.flush()) {
    std::cerr << "vdispd: standard output cannot be written\n";
    parsed.exit_code = EX_IOERR;
  }
  return parsed;
}

}  // namespace vdisp
