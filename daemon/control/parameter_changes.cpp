// parameter_changes.cpp: what changes the configuration of a running daemon: set, undo, save, another reading of vdisp.cfg.
// SPDX-License-Identifier: Apache-2.0
#include <sstream>

#include "config/change.h"
#include "daemon/control/config_file.h"
#include "daemon/control/live_parameters.h"
#include "daemon/control/reply_text.h"

namespace vdisp {
namespace {

constexpr size_t most_steps = 1000;  // that undo can take back

std::string by_socket(const Sender& sender) { return "control socket," + sent_by(sender.pid, sender.uid); }

std::string counted(size_t count, const char* what) { return std::to_string(count) + " " + what + (count == 1 ? "" : "s"); }

}  // namespace

void LiveParameters::tell_change(const Parameter& row, const std::string& before, const std::string& origin) {
  tell_("parameter " + row.name() + ": " + before + " -> " + row.get(config_) + " (" + origin + ")", false);
}

void LiveParameters::tell_slide() {
  if (slide_.row && slide_.row->get(config_) != slide_.before) tell_change(*slide_.row, slide_.before, by_socket(slide_.sender));
  slide_.row = nullptr;
}

void LiveParameters::keep(Step step) {
  if (steps_.size() == most_steps) steps_.erase(steps_.begin());
  steps_.push_back(std::move(step));
}

void LiveParameters::set(const Request& request, Result& result) {
  ReplyMessage& reply = result.message;
  std::string complaint;
  const Parameter* row = named_parameter(request.message.key, complaint);
  const auto refuse = [&](Answer why, std::string_view text) {
    reply.answer = why;
    put(reply.text, text);
  };
  if (!row) return refuse(Answer::unknown, complaint);
  const std::string before = row->get(config_);
  describe(*row, reply);
  Config changed = config_;
  complaint = change(changed, *row, request.message.value);
  if (!complaint.empty()) return refuse(Answer::refused, complaint);
  if (row->when == When::restart)
    return refuse(Answer::needs_restart, row->name() + " needs a restart: write it into vdisp.cfg and start vdispd again");
  const bool joined = request.message.joined && !steps_.empty() && steps_.back().connection == request.sender.connection &&
                      steps_.back().before.front().first == row;
  if (!joined || slide_.row != row) tell_slide();
  config_ = std::move(changed);
  if (!joined) {
    keep({{{row, before}}, request.sender.connection});
    tell_change(*row, before, by_socket(request.sender));
  } else if (!slide_.row) {
    slide_ = {row, before, request.sender};
  }
  describe(*row, reply);
  result.changed = {row};
  result.value = config_;
}

/// The states before are gone through backwards, and each was checked as a whole.
void LiveParameters::undo(const Sender& sender, Result& result) {
  ReplyMessage& reply = result.message;
  tell_slide();
  if (steps_.empty()) {
    reply.answer = Answer::refused;
    return put(reply.text, "nothing to undo: no parameter was changed since the start, or all is undone");
  }
  const Step step = std::move(steps_.back());
  steps_.pop_back();
  std::string text;
  for (const auto& [row, before] : step.before) {
    const std::string now = row->get(config_);
    row->set(config_, before);
    tell_change(*row, now, "undo, " + by_socket(sender));
    text += (text.empty() ? "" : ", ") + row->name() + " = " + before;
    result.changed.push_back(row);
  }
  describe(*step.before.front().first, reply);
  if (step.before.size() > 1) put(reply.text, text);
  result.value = config_;
}

/// What differs from the file: the values that set has changed for good.
std::vector<std::pair<const Parameter*, std::string>> LiveParameters::changes() const {
  std::vector<std::pair<const Parameter*, std::string>> values;
  for (const Parameter& row : parameters())
    if (row.when == When::live && row.get(saved_) != row.get(config_)) values.emplace_back(&row, row.get(config_));
  return values;
}

void LiveParameters::save(const Sender& sender, Result& result) {
  ReplyMessage& reply = result.message;
  tell_slide();
  std::string complaint;
  size_t saved = 0;
  if (origin_.file.empty()) {
    complaint = "the daemon was started without a vdisp.cfg: there is nothing to save to; start it with -c FILE";
  } else {
    // What somebody else wrote there is taken first: it is not to be lost, and what was set goes before it.
    const auto text = read_text(origin_.file);
    if (text && *text != file_text_) complaint = read_again(Precedence::hand, "the file was changed", result);
    const auto values = changes();
    saved = values.size();
    if (complaint.empty() && saved > 0) complaint = replace_config(origin_.file, file_text_, rewritten(file_text_, values));
  }
  reply.answer = complaint.empty() ? Answer::done : Answer::failed;
  if (complaint.empty()) {
    for (const auto& [row, value] : changes()) row->set(saved_, value);
    seen_text_ = file_text_;
    tell_(origin_.file.string() + ": " + counted(saved, "value") + " saved (" + by_socket(sender) + ")", false);
  }
  put(reply.value, origin_.file.string());
  put(reply.text, complaint.empty() ? std::to_string(saved) + " changed keys" : complaint);
}

/// The file as it is now, with the options of the command line. What is wrong with it is told, and is the complaint: nothing was changed.
std::string LiveParameters::read_again(Precedence precedence, const std::string& origin, Result& result) {
  const std::string file = origin_.file.string();
  seen_text_ = read_text(origin_.file).value_or("");
  if (const auto kind = std::filesystem::status(origin_.file).type(); kind == std::filesystem::file_type::fifo ||
                                                                      kind == std::filesystem::file_type::character ||
                                                                      kind == std::filesystem::file_type::socket) {
    ++reloads_refused_;
    const std::string fault = file + " is no regular file, and would be waited for: nothing was changed";
    tell_(fault + " (" + origin + ")", true);
    return fault;
  }
  Config now;
  const ConfigReading reading = read_config(origin_.file, origin_.options, now);
  for (const auto* lines : {&reading.complaints, &reading.notes}) {
    for (const Complaint& complaint : *lines) {
      std::ostringstream line;
      line << complaint;
      tell_(line.str(), lines == &reading.complaints);
    }
  }
  std::string fault;
  if (!reading.complaints.empty()) {
    fault = file + " has " + counted(reading.complaints.size(), "fault") + ": nothing was changed";
  } else if (fault = take(now, precedence, origin, result); !fault.empty()) {
    fault = file + ": " + fault + "; nothing was changed";
  }
  if (!fault.empty()) {
    ++reloads_refused_;
    tell_(fault + " (" + origin + ")", true);
    return fault;
  }
  file_text_ = seen_text_;
  ++reloads_;
  return {};
}

/// What was read, where it is whole.
std::string LiveParameters::take(const Config& now, Precedence precedence, const std::string& origin, Result& result) {
  const Config before = config_;
  const Reload reload = merge(saved_, now, config_, precedence);
  if (!reload.fault.empty()) return reload.fault;
  saved_ = now;
  const std::string file = origin_.file.string();
  Step step{{}, 0};
  for (const Parameter* row : reload.taken) {
    step.before.emplace_back(row, row->get(before));
    tell_change(*row, row->get(before), file + ", " + origin);
    result.changed.push_back(row);
  }
  if (!step.before.empty()) keep(std::move(step));
  result.value = config_;
  tell_(file + " was read again (" + origin + "): " + counted(reload.taken.size(), "parameter") + " changed", false);
  const auto list = [&](const std::vector<const Parameter*>& rows, const char* end) {
    std::string line;
    for (const Parameter* row : rows)
      line += (line.empty() ? "" : ", ") + row->name() + " = " + row->get(now) + " (now " + row->get(config_) + ")";
    if (!rows.empty()) tell_(file + ": " + line + end, false);
  };
  list(reload.restart, reload.restart.size() == 1 ? " needs a restart" : " need a restart");
  list(reload.kept, reload.kept.size() == 1 ? " was set by hand, and stays" : " were set by hand, and stay");
  return {};
}

void LiveParameters::reload(Precedence precedence, const std::string& origin) {
  tell_slide();
  if (origin_.file.empty()) return tell_(origin + ": the daemon was started without a vdisp.cfg: there is nothing to read again", false);
  // Its own save, a touched file, or one that is still as wrong as it was.
  if (precedence == Precedence::hand && read_text(origin_.file).value_or("") == seen_text_) return;
  Result* result = free_result();
  if (!result) return;
  try {
    read_again(precedence, origin, *result);
  } catch (const std::exception& error) {
    tell_(origin_.file.string() + ": " + error.what() + "; nothing was changed", true);
  }
  results_.push();
}

}  // namespace vdisp
