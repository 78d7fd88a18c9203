// main.cpp: vdisp-drive: options, signals, and the loop that keeps the motors told.
// SPDX-License-Identifier: Apache-2.0
#include <sched.h>
#include <sys/resource.h>
#include <sysexits.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <ctime>
#include <filesystem>
#include <iostream>
#include <new>
#include <system_error>

#include "config/config.h"
#include "daemon/core/clock.h"
#include "daemon/log/log.h"
#include "daemon/tools/drive/motors.h"
#include "daemon/tools/drive/orders.h"
#include "daemon/tools/drive/report.h"
#include "daemon/tools/drive/settings.h"

namespace vdisp::drive {
namespace {

constexpr const char* installed_config = "/etc/vdisp/vdisp.cfg";
constexpr const char* no_memory = "not enough memory; free some, or raise its limit (ulimit -v, MemoryMax)";
constexpr int64_t longest_nap_ns = 10'000'000;        // an order that turns blind is seen so late at most
constexpr int64_t shortest_nap_ns = 1'000'000;        // while a command waits for the port
constexpr int64_t longest_ending_ns = 2'000'000'000;  // with stopDeceleration

volatile std::sig_atomic_t stops_asked = 0;

struct Options {
  std::string file, port;
  std::vector<std::string> sets;
  bool synthetic = false, json = false, check_only = false;
};

int complain(int code, const std::string& what) {
  std::cerr << "vdisp-drive: " << what << std::endl;
  return code;
}

/// -1: there is something to run.
int parse(int argc, char** argv, Options& options) {
  CLI::App app(
      "Drives the motors: reads the daemon's drive orders, says them to a motor controller over a serial port, and stops whenever\n"
      "an order is blind, stale or missing.",
      "vdisp-drive");
  app.set_version_flag("--version", "vdisp-drive " VDISP_VERSION);
  app.add_option("-c,--config", options.file, "Configuration; without it /etc/vdisp/vdisp.cfg, or the defaults where that does not exist")
      ->type_name("FILE");
  app.add_option("--set", options.sets, "Override one parameter; may be repeated")->type_name("SECTION.KEY=VALUE")->allow_extra_args(false);
  app.add_option("--port", options.port, "Serial port, instead of [drive] port; - writes the commands to standard output")
      ->type_name("DEVICE");
  app.add_flag("--allow-synthetic", options.synthetic, "Drive also by orders that come from the simulator or from files");
  app.add_flag("--json", options.json, "The state as a line of JSON, once a second and on each change");
  app.add_flag("--check-config", options.check_only, "Say all that is wrong with the configuration and end");
  app.footer(
      "Exit codes: 0 done (also SIGTERM, Ctrl-C), 64 usage, 66 no configuration file, 71 no memory, 74 output failed,\n"
      "75 internal, 77 no permission for port or daemon, 78 wrong configuration.");
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& done) {
    return app.exit(done);
  } catch (const CLI::ParseError& error) {
    return complain(EX_USAGE, std::string(error.what()) + "; see vdisp-drive --help");
  }
  if (options.json && options.port == "-") return complain(EX_USAGE, "--json and --port - both write to standard output; leave one out");
  return -1;
}

/// 0, or the exit code after all complaints have been said.
int read(const Options& options, Config& config, Settings& settings) {
  std::error_code ignored;
  const bool installed = options.file.empty() && std::filesystem::exists(installed_config, ignored);
  const std::string file = installed ? installed_config : options.file;
  const ConfigReading reading = read_config(file, options.sets, config);
  for (const Complaint& note : reading.notes) std::cerr << "vdisp-drive: " << note << '\n';
  for (const Complaint& complaint : reading.complaints) std::cerr << complaint << '\n';
  if (reading.exit_code != 0) return reading.exit_code;
  std::vector<std::string> complaints;
  settings = read_settings(config, options.port, complaints);
  for (const std::string& complaint : complaints) complain(0, (file.empty() ? "" : file + ": ") + complaint);
  if (complaints.empty() && options.json && settings.from.port == "-")
    return complain(EX_USAGE, "--json and port = - both write to standard output; leave one out");
  return complaints.empty() ? EX_OK : EX_CONFIG;
}

/// Until the signal comes or the moment; signals are let in only here, so that none is missed.
void nap(int64_t until_ns) {
  const int64_t left = until_ns - monotonic_ns();
  if (left <= 0) return;
  const timespec time{left / 1'000'000'000, left % 1'000'000'000};
  sigset_t none;
  sigemptyset(&none);
  pselect(0, nullptr, nullptr, nullptr, &time, &none);
}

/// A late command is worse than a late frame, and there is little to do for one. Where it is not permitted there is no harm: the
/// controller's watchdog bears two missing ones.
void go_first() {
  const sched_param least{sched_get_priority_min(SCHED_RR)};
  if (sched_setscheduler(0, SCHED_RR | SCHED_RESET_ON_FORK, &least) != 0) (void)setpriority(PRIO_PROCESS, 0, -10);
}

void catch_signals() {
  sigset_t caught;
  sigemptyset(&caught);
  for (int signal : {SIGINT, SIGTERM, SIGHUP}) {
    sigaddset(&caught, signal);
    std::signal(signal, [](int) { stops_asked = stops_asked + 1; });
  }
  sigprocmask(SIG_BLOCK, &caught, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
}

/// What cannot pass by itself ends the program before it has ever had port and daemon; later it is waited for, as the motors stand.
class Beginning {
 public:
  int judge(const Motors& motors, Orders& orders, int64_t now_ns) {
    if (!had_port_) {
      had_port_ = true;  // one look is enough: a port that comes later has its rights later
      const int code = motors.port().exit_code();
      if (!motors.port().is_open() && code != EX_UNAVAILABLE) return complain(code, motors.port().fault());
    }
    if (had_daemon_ || now_ns < next_ns_) return EX_OK;
    next_ns_ = now_ns + 500'000'000;
    const Connection connection = orders.connection();
    had_daemon_ = connection == Connection::connected;
    if (connection != Connection::no_permission && connection != Connection::wrong_name) return EX_OK;
    return complain(connection == Connection::no_permission ? EX_NOPERM : EX_CONFIG, orders.detail({}));
  }

 private:
  bool had_port_ = false, had_daemon_ = false;
  int64_t next_ns_ = 0;
};

int drive(const Config& config, const Settings& settings, const Options& options) {
  Orders orders(config.main.name, settings.from.timeout, options.synthetic);
  Motors motors(settings);
  Report report(options.json);
  Beginning beginning;
  int64_t ending_ns = 0;
  for (;;) {
    const bool ending = stops_asked > 0;
    const Order order = orders.look();
    const int64_t now = monotonic_ns();
    if (ending && ending_ns == 0) ending_ns = now;
    motors.serve(order, ending, now);
    if (const int code = beginning.judge(motors, orders, now); code != EX_OK) return code;
    report.see(motors, order, orders, now);
    if (!motors.port().is_open() && motors.port().exit_code() == EX_IOERR) return complain(EX_IOERR, motors.port().fault());
    if (ending && (motors.standing() || !motors.port().is_open() || stops_asked > 1 || now - ending_ns > longest_ending_ns)) break;
    const int64_t begin = monotonic_ns();
    nap(std::clamp(motors.next_ns(), begin + shortest_nap_ns, begin + longest_nap_ns));
  }
  motors.finish();
  report.finish(motors, monotonic_ns());
  return EX_OK;
}

int run(int argc, char** argv) {
  Options options;
  int code = parse(argc, argv, options);
  if (code >= 0) return code;
  Config config;
  Settings settings;
  code = read(options, config, settings);
  if (code == EX_OK && options.check_only) std::cout << "nothing wrong\n" << std::flush;
  if (code != EX_OK || options.check_only) return code;
  catch_signals();
  go_first();
  try {
    log::start(config.main.debug, "vdisp-drive");
    code = drive(config, settings, options);  // whatever is thrown, the motors have been stopped by then
  } catch (const std::bad_alloc&) {
    code = complain(EX_OSERR, no_memory);
  } catch (const std::system_error& error) {  // what cannot be had is a thread
    code = complain(EX_OSERR, std::string(no_memory) + " (" + error.what() + ")");
  } catch (const std::exception& error) {
    code = complain(EX_TEMPFAIL, std::string("internal: ") + error.what());
  }
  log::stop();
  return code;
}

}  // namespace
}  // namespace vdisp::drive

int main(int argc, char** argv) { return vdisp::drive::run(argc, argv); }
