// parameters.cpp: vdisp-probe set, get, save, undo: the parameters of a running daemon.
// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "ipc/include/vdisp/control.h"
#include "probe/samples.h"
#include "probe/terminal.h"
#include "probe/words.h"

namespace vdisp {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const ParameterInfo& info) {
  return {{"key", info.key},   {"value", info.value}, {"default", info.standard}, {"allowed", info.allowed},
          {"unit", info.unit}, {"live", info.live},   {"help", info.help}};
}

std::string line_of(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n"; }

/// What holds after set and undo.
void print_change(const ParameterInfo& info, bool json) {
  if (json) {
    Json told{{"key", info.key}, {"value", info.value}};
    if (!info.help.empty()) told["all"] = info.help;
    told.update(Json{{"config_generation", info.config_generation}, {"sequence", info.sequence}});
    print(line_of(told));
  } else {
    print(info.key + " = " + info.value + ", from frame " + std::to_string(info.sequence) + " on (generation " +
          std::to_string(info.config_generation) + ")\n");
  }
}

}  // namespace

int set(const Options& options) {
  Control control(options.control);
  ParameterInfo info;
  require_done(control, options, [&] { return control.set(options.key, options.value, &info); });
  print_change(info, options.json);
  return 0;
}

int undo(const Options& options) {
  Control control(options.control);
  ParameterInfo info;
  require_done(control, options, [&] { return control.undo(&info); });
  // The last change may have been another reading of vdisp.cfg, with several keys: then the help tells them.
  if (options.json || info.help.empty()) {
    print_change(info, options.json);
  } else {
    print(info.help + ", from frame " + std::to_string(info.sequence) + " on (generation " + std::to_string(info.config_generation) +
          ")\n");
  }
  return 0;
}

int save(const Options& options) {
  Control control(options.control);
  require_done(control, options, [&] { return control.save(); });
  print(options.json ? line_of({{"saved", control.message()}}) : control.message() + "\n");
  return 0;
}

int get(const Options& options) {
  const bool one = !options.key.empty();
  Control control(options.control, one ? std::chrono::seconds(2) : limit_of_all);
  std::vector<ParameterInfo> all(1);
  require_done(control, options, [&] { return one ? control.get(options.key, all[0]) : control.get_all(all); });
  std::string text;
  Json json = Json::array();
  for (const ParameterInfo& info : all) {
    json.push_back(json_of(info));
    text += info.key + " = " + info.value + (info.live ? "" : "  (restart)") +
            (info.value == info.standard ? "" : "  (default " + info.standard + ")") + "\n";
  }
  const ParameterInfo& info = all[0];
  if (one)
    text = info.key + " = " + info.value + "\n" + info.allowed + ", default " + info.standard + ", " + (info.live ? "live" : "restart") +
           "\n" + info.help + "\n";
  print(options.json ? line_of(one ? json[0] : json) : text);
  return 0;
}

}  // namespace vdisp
