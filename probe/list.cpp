// list.cpp: vdisp-probe list: what the daemon offers.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <iostream>
#include <nlohmann/json.hpp>

#include "probe/attach.h"
#include "probe/readout.h"
#include "probe/terminal.h"
#include "probe/tree.h"

namespace vdisp {
namespace {

void print_json(const std::vector<CatalogueEntry>& entries) {
  nlohmann::ordered_json topics = nlohmann::ordered_json::array();
  for (const CatalogueEntry& entry : entries) {
    nlohmann::ordered_json parents = nlohmann::ordered_json::array();
    for (int parent : entry.parents) {
      if (parent >= 0 && parent < static_cast<int>(entries.size())) parents.push_back(name_of(entries[parent]));
    }
    topics.push_back({{"topic", name_of(entry)},
                      {"pixel", name(entry.spec.pixel)},
                      {"width", entry.spec.width},
                      {"height", entry.spec.height},
                      {"parents", parents},
                      {"stage", entry.stage},
                      {"watched", entry.watched != 0},
                      {"runs", entry.runs},
                      {"invalid", entry.invalid},
                      {"drops", entry.drops},
                      {"last_ns", entry.last_ns},
                      {"mean_ns", entry.mean_ns},
                      {"max_ns", entry.max_ns}});
  }
  std::cout << topics.dump(1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) << "\n";
}

void print_tree(const std::vector<CatalogueEntry>& entries) {
  const bool ascii = !utf8_terminal();
  const std::vector<TreeLine> lines = tree_of(entries, ascii);
  const auto label = [&](const TreeLine& line) { return line.branch + std::string(name_of(entries[line.entry])); };
  size_t width = 5;
  for (const TreeLine& line : lines) width = std::max(width, letters(label(line)));
  std::printf("%-*s  %-20s %7s %9s %9s\n", static_cast<int>(width), "topic", "format", "watched", "runs", "mean ms");
  for (const TreeLine& line : lines) {
    const CatalogueEntry& entry = entries[line.entry];
    const std::string text = label(line);
    char mean[16] = "-";
    if (entry.runs) std::snprintf(mean, sizeof mean, "%.2f", static_cast<double>(entry.mean_ns) / 1e6);
    std::printf("%s%*s  %-20s %7s %9llu %9s  %s\n", text.c_str(), static_cast<int>(width - letters(text)), "",
                spec_words(entry.spec).c_str(), entry.watched ? "yes" : "-", static_cast<unsigned long long>(entry.runs), mean,
                line.also.c_str());
  }
}

}  // namespace

int list(const Options& options) {
  stop_on_signals();
  Client client(options.name);
  attach(client, options);
  const std::vector<CatalogueEntry> entries = topics_of(client);
  if (options.json)
    print_json(entries);
  else
    print_tree(entries);
  return 0;
}

}  // namespace vdisp
