// assignments.cpp: the values that a file and options give, put into a Config, with everything that is wrong with them.
// SPDX-License-Identifier: Apache-2.0
#include "config/assignments.h"

#include <sysexits.h>

#include <ostream>

#include "config/quoting.h"
#include "config/suggestion.h"

namespace vdisp {

constexpr size_t most_complaints = 100;  // of a file that is no vdisp.cfg at all

void Assignments::complain(const Place& place, std::string text) {
  if (result_.exit_code == 0) result_.exit_code = EX_CONFIG;
  if (result_.complaints.size() == most_complaints) {
    result_.complaints.push_back({place.file, place.line, "more than 100 complaints, the rest is left out"});
  }
  if (result_.complaints.size() < most_complaints) result_.complaints.push_back({place.file, place.line, std::move(text)});
}

void Assignments::fail(const Place& place, std::string text, int exit_code) {
  complain(place, std::move(text));
  result_.exit_code = exit_code;
}

void Assignments::options_begin(std::filesystem::path folder) {
  options_ = true;
  folder_ = std::move(folder);
  given_there_.clear();
}

void Assignments::assign(const Place& place, std::string_view section, std::string_view key, std::string_view raw) {
  if (section == "image source" && key == "coorsize") {
    result_.notes.push_back({place.file, place.line, "coorsize is taken for corrsize"});
    key = "corrsize";
  }
  const Parameter* row = find_parameter(section, key);
  if (!row) return complain(place, unknown_key(section, key));
  if (is_repeated(*row, place)) return;
  Unquoted value = unquoted(raw, row->kind == Kind::path);
  if (!value.error.empty()) {
    wrong_.insert(row);
    return complain(place, std::string(key) + " = " + printable(raw) + ", " + value.error);
  }
  if (row->kind == Kind::path && !value.text.empty()) value.text = (folder_ / value.text).string();
  const std::string before = row->get(config_);
  if (const auto error = row->set(config_, value.text)) {
    wrong_.insert(row);
    return complain(place, *error);
  }
  if (key == "angRot") compare_angles(*row, before, place);
}

bool Assignments::is_repeated(const Parameter& row, const Place& place) {
  const auto first = given_there_.find(&row);
  // Of options the last one holds, as everywhere.
  if (first != given_there_.end() && !options_) {
    complain(place, std::string(row.key) + " stands twice in [" + std::string(row.section) + "], first in line " +
                        std::to_string(first->second.line));
    return true;
  }
  Place numbered = place;
  numbered.order = ++count_;
  given_[&row] = given_there_[&row] = numbered;
  return false;
}

/// angRot is one value that the paper's file has in two sections.
void Assignments::compare_angles(const Parameter& row, const std::string& before, const Place& place) {
  const Parameter* twin = find_parameter(row.section == "Map" ? "Limit obstacle" : "Map", row.key);
  const auto other = given_there_.find(twin);
  const std::string now = row.get(config_);
  if (other == given_there_.end() || wrong_.contains(twin) || now == before) return;
  const std::string where = !options_ ? "line " + std::to_string(other->second.line) : other->second.file;
  complain(place, "angRot = " + now + " in [" + std::string(row.section) + "] but " + before + " in [" + std::string(twin->section) +
                      "] (" + where + "), must be the same in both, or in one of them only");
}

void Assignments::report_contradictions(const std::string& file) {
  for (const Contradiction& contradiction : check(config_)) {
    Place place{file, 0, 0};
    bool judged = true;
    for (const std::string& name : contradiction.parameters) {
      const Parameter* row = find_parameter(name);
      if (wrong_.contains(row)) judged = false;  // it has its complaint
      const auto given = given_.find(row);
      if (given != given_.end() && given->second.order > place.order) place = given->second;
    }
    if (judged) complain(place, contradiction.text);
  }
}

ConfigReading Assignments::finish(const std::string& file, Config& config) {
  report_contradictions(file);
  const auto& source = config_.image_source;
  if (source.source == "auto" && !source.left.empty()) {
    const Place& place = given_[find_parameter("image source.left")];
    result_.notes.push_back({place.file, place.line, "left has no effect with source = auto; source = files reads recorded pairs"});
  }
  if (result_.complaints.empty()) config = config_;
  return std::move(result_);
}

std::ostream& operator<<(std::ostream& out, const Complaint& complaint) {
  out << complaint.file;
  if (complaint.line > 0) out << ':' << complaint.line;
  return out << ": " << complaint.text;
}

}  // namespace vdisp
