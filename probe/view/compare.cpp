// compare.cpp: vdisp-probe compare: what a parameter would change, on the same frame, before it is set.
// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "ipc/png.h"
#include "probe/attach.h"
#include "probe/comparison_page.h"
#include "probe/format.h"
#include "probe/terminal.h"
#include "probe/view/window.h"

namespace vdisp {
namespace {

constexpr int page_width = 1400;

std::string json(const Comparison& comparison) {
  nlohmann::ordered_json all{
      {"changes", comparison.changes}, {"frames", {comparison.first, comparison.last}}, {"stages", nlohmann::ordered_json::array()}};
  for (const ComparedStage& stage : comparison.stages) {
    const Image &before = stage.before.image(), &after = stage.after.image();
    nlohmann::ordered_json told{{"stage", stage.topic}, {"old_valid", before.valid()}, {"new_valid", after.valid()}};
    told["pixels"] = stage.comparable() ? nlohmann::ordered_json(stage.pixels) : nlohmann::ordered_json(nullptr);
    told["differing"] = stage.comparable() ? nlohmann::ordered_json(stage.differing) : nlohmann::ordered_json(nullptr);
    if (*stage.count.what) told["counted"] = {{"what", stage.count.what}, {"old", stage.count.before}, {"new", stage.count.after}};
    all["stages"].push_back(told);
  }
  return all.dump() + "\n";
}

std::string words(const Comparison& comparison) {
  std::string text;
  for (const std::string& change : comparison.changes) text += change + "\n";
  text += format("frame %llu, the last of %llu that both runs begin with; not repeated: odometry, IMU, what was seen before\n",
                 static_cast<unsigned long long>(comparison.last), static_cast<unsigned long long>(comparison.frames));
  for (const ComparedStage& stage : comparison.stages) text += format("%-18s ", stage.topic.c_str()) + difference_words(stage) + "\n";
  return text;
}

/// One stage at a time, Up and Down; Left and Right do the same.
void show(const Comparison& comparison, const Options& options) {
  std::vector<const ComparedStage*> stages;
  for (const ComparedStage& stage : comparison.stages) stages.push_back(&stage);
  const ComparedStage* first = chosen_stages(comparison, options.topics).at(0);
  auto at = static_cast<size_t>(std::find(stages.begin(), stages.end(), first) - stages.begin());
  Window window("vdisp-probe compare", 1200, 440);
  const auto draw = [&] {
    window.set_title("compare " + stages[at]->topic);
    Picture page(window.width(), window.height(), colours::background);
    const Picture row = comparison_page(comparison, {stages[at]}, window.width());
    page.draw(row, {0, 0, row.width(), row.height()});
    page.text(12, page.height() - 22, "Up, Down: stage   q: end", colours::dim);
    window.show(page);
  };
  draw();
  while (!stopped()) {
    const auto input = window.wait(250);
    if (!input) continue;
    const size_t count = stages.size();
    switch (*input) {
      case Input::quit: return;
      case Input::next_stage:
      case Input::next_image:
      case Input::pressed: at = (at + 1) % count; break;
      case Input::previous_stage:
      case Input::previous_image: at = (at + count - 1) % count; break;
      default: break;
    }
    draw();
  }
}

}  // namespace

int compare(const Options& options) {
  stop_on_signals();
  const Comparison comparison = compare_frames(options);
  if (comparison.stages.empty()) throw ProbeError(75, "nothing was made to be compared");
  if (!options.output.empty()) {
    const Picture page = comparison_page(comparison, chosen_stages(comparison, options.topics), page_width);
    write_file(options.output, encode_png(PngKind::rgb8, page.width(), page.height(), [&](int y) { return page.row(y); }));
  }
  if (options.json || !options.output.empty()) {
    print(options.json ? json(comparison) : words(comparison));
    return 0;
  }
  try {
    show(comparison, options);
  } catch (const NoWindow& error) {
    throw ProbeError(69, std::string(error.what()) + "; -o FILE writes the picture");
  }
  return 0;
}

}  // namespace vdisp
