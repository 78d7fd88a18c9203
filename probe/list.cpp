// list.cpp: vdisp-probe list: what the daemon offers.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "probe/attach.h"
#include "probe/readout.h"
#include "probe/terminal.h"
#include "probe/tree.h"

namespace vdisp {
namespace {

std::string json_of(const std::vector<CatalogueEntry>& entries) {
  nlohmann::ordered_json topics = nlohmann::ordered_json::array();
  for (const CatalogueEntry& entry : entries) {
    nlohmann::ordered_json parents = nlohmann::ordered_json::array(), delayed = nlohmann::ordered_json::array();
    const auto known = [&](int index) { return index >= 0 && index < static_cast<int>(entries.size()); };
    for (int parent : entry.parents) {
      if (known(parent)) parents.push_back(name_of(entries[parent]));
      if (known(delayed_parent(parent))) delayed.push_back(name_of(entries[delayed_parent(parent)]));
    }
    topics.push_back({{"topic", name_of(entry)},
                      {"pixel", name(entry.spec.pixel)},
                      {"width", entry.spec.width},
                      {"height", entry.spec.height},
                      {"parents", parents},
                      {"delayed_parents", delayed},
                      {"stage", entry.stage},
                      {"watched", entry.watched != 0},
                      {"runs", entry.runs},
                      {"invalid", entry.invalid},
                      {"drops", entry.drops},
                      {"last_ns", entry.last_ns},
                      {"mean_ns", entry.mean_ns},
                      {"max_ns", entry.max_ns}});
  }
  return topics.dump(1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

std::string table_of(const std::vector<CatalogueEntry>& entries) {
  const bool ascii = !utf8_terminal();
  const std::vector<TreeLine> lines = tree_of(entries, ascii);
  const auto label = [&](const TreeLine& line) { return line.branch + std::string(name_of(entries[line.entry])); };
  size_t width = 5;
  for (const TreeLine& line : lines) width = std::max(width, letters(label(line)));
  const auto padded = [&](const std::string& text) { return text + std::string(width - letters(text), ' '); };
  std::string table = padded("topic") + "  format               watched      runs   mean ms\n";
  for (const TreeLine& line : lines) {
    const CatalogueEntry& entry = entries[line.entry];
    char columns[128], mean[16] = "-";
    if (entry.runs) std::snprintf(mean, sizeof mean, "%.2f", static_cast<double>(entry.mean_ns) / 1e6);
    std::snprintf(columns, sizeof columns, "  %-20s %7s %9llu %9s  ", spec_words(entry.spec).c_str(), entry.watched ? "yes" : "-",
                  static_cast<unsigned long long>(entry.runs), mean);
    table += padded(label(line)) + columns + line.also + "\n";
  }
  return table;
}

}  // namespace

int list(const Options& options) {
  stop_on_signals();
  Client client(options.name);
  attach(client, options);
  const std::vector<CatalogueEntry> entries = topics_of(client);
  print(options.json ? json_of(entries) : table_of(entries));
  return 0;
}

}  // namespace vdisp
