// words.h: the words of vdisp-probe: one function, one file each. They return the exit code, and throw ProbeError or WriteError.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

namespace vdisp {

/// One line: what was found, what would be right.
class ProbeError : public std::runtime_error {
 public:
  ProbeError(int code, const std::string& what) : std::runtime_error(what), exit_code(code) {}
  int exit_code;
};

struct Options {
  std::string name = "IPLObstacleDetection";  ///< [main] name of the daemon
  double wait_s = 0;                          ///< how long to wait for a daemon
  bool json = false, once = false;
  bool picture = false;             ///< dump: also as painted
  uint64_t frames = 1;              ///< dump
  std::filesystem::path output;     ///< dump: folder; sheet: file
  std::string control;              ///< path of the control socket; empty: the usual places
  std::string key, value;           ///< set, get: parameter; send: kind and label of an event
  std::filesystem::path input;      ///< send: CSV; empty: standard input
  double rate = 0;                  ///< send: lines a second; 0: as the lines say, or as they come
  int row = 0, column = 0;          ///< why: of the cell, or of the pixel
  bool pixel = false;               ///< why: a pixel of the left view
  double seconds = 0;               ///< latency: how long to measure, 0: since the daemon's start; record: how long, 0: until it is stopped
  bool reader = false;              ///< latency: as a reader gets it
  bool running = false;             ///< record: the stages do not begin anew
  bool window = false;              ///< record: in the window
  bool drive = false;               ///< view: the keys drive the rover
  double speed = 0.3, turn = 0.5;   ///< view, record: what a key held means, m/s and rad/s
  std::vector<std::string> sets;    ///< compare: KEY=VALUE
  std::vector<std::string> topics;  ///< dump: empty for all; view, map: the one to show; replay: options of vdispd
};

int view(const Options& options);
int list(const Options& options);
int dump(const Options& options);
int map(const Options& options);
int sheet(const Options& options);
int stats(const Options& options);
int latency(const Options& options);
int compare(const Options& options);
int why(const Options& options);
int set(const Options& options);
int get(const Options& options);
int save(const Options& options);
int undo(const Options& options);
int send(const Options& options);
int record(const Options& options);
int replay(const Options& options);
int dump_flight(const Options& options);

}  // namespace vdisp
