// record.cpp: vdisp-probe record: pairs, labels and inputs of a running daemon to a folder, at its rate or a lower one.
// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "probe/drive_recorder.h"
#include "probe/format.h"
#include "probe/recorded.h"
#include "probe/terminal.h"

namespace vdisp {

void tell_recorded(const DriveRecorder& recorder, const Options& options) {
  if (options.json) {
    nlohmann::ordered_json json{
        {"folder", options.output.string()}, {"steps", recorder.steps()}, {"pairs", recorder.pairs()}, {"lost", recorder.lost()}};
    for (const Label label : {Label::forward, Label::left, Label::right, Label::none})
      json["labels"][std::string(name(label))] = recorder.of(label);
    json["warning"] = recorder.warning();
    print(json.dump() + "\n");
    return;
  }
  print(std::to_string(recorder.pairs()) + " pairs in " + options.output.string() + ": " + std::to_string(recorder.of(Label::forward)) +
        " forward, " + std::to_string(recorder.of(Label::left)) + " left, " + std::to_string(recorder.of(Label::right)) + " right, " +
        std::to_string(recorder.of(Label::none)) + " without a label; " + std::to_string(recorder.lost()) + " frames missed\n");
  if (!recorder.warning().empty()) print("note: " + recorder.warning() + "\n");
}

int record(const Options& options) {
  stop_on_signals();
  Client client(options.name);
  attach(client, options);
  Control control(options.control);
  DriveRecorder recorder(client, control, options);
  while (!stopped() && recorder.poll(Client::Time(100))) {
  }
  recorder.finish();
  tell_recorded(recorder, options);
  return 0;
}

}  // namespace vdisp
