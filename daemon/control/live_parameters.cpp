// live_parameters.cpp: set, get, save, undo.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/control/live_parameters.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <string_view>
#include <system_error>

#include "config/change.h"
#include "daemon/control/config_file.h"

namespace vdisp {
namespace {

constexpr size_t waiting = 64;       // requests, of all clients together
constexpr size_t most_steps = 1000;  // that undo can take back

template <size_t size>
void put(char (&to)[size], std::string_view text) {
  const size_t length = std::min(text.size(), size - 1);
  std::memcpy(to, text.data(), length);
  std::memset(to + length, 0, size - length);
}

}  // namespace

LiveParameters::LiveParameters(Config& config, std::filesystem::path file)
    : in_use_(config), config_(config), saved_(config), file_(std::move(file)), requests_(waiting), results_(waiting) {
  if (!file_.empty()) file_text_ = read_text(file_).value_or("");
  sem_init(&asked_, 0, 0);
  thread_ = std::thread([this] { think(); });
}

LiveParameters::~LiveParameters() {
  ending_ = true;
  sem_post(&asked_);
  thread_.join();
  sem_destroy(&asked_);
}

bool LiveParameters::ask(const ParameterMessage& message, uint64_t client) noexcept {
  Request* place = requests_.free_place();
  if (!place) return false;
  place->message = message;
  place->client = client;
  requests_.push();
  sem_post(&asked_);
  return true;
}

bool LiveParameters::next(Reply& reply) noexcept {
  Result* result = results_.front();
  if (!result) return false;
  if (result->changed) {
    result->changed->exchange(in_use_, result->value);
    ++generation_;
  }
  result->message.config_generation = generation_;
  reply = {result->client, &result->message};
  return true;
}

void LiveParameters::think() {
  while (true) {
    while (sem_wait(&asked_) != 0 && errno == EINTR) {
    }
    if (ending_) return;
    Request* request = requests_.front();
    Result* result = request ? results_.free_place() : nullptr;
    if (!request) continue;
    // The loop takes results faster than it asks: a place becomes free. Sleeping is as good as anything.
    while (!result && !ending_) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      result = results_.free_place();
    }
    if (!result) return;
    answer(*request, *result);
    requests_.pop();
    results_.push();
  }
}

void LiveParameters::answer(const Request& request, Result& result) {
  result.client = request.client;
  result.changed = nullptr;
  ReplyMessage& reply = result.message;
  reply = {};
  reply.header = {command_magic, command_version, CommandType::reply, sizeof reply, request.message.header.number};
  reply.count = static_cast<uint32_t>(parameters().size());
  try {
    switch (request.message.header.type) {
      case CommandType::set: return set(request.message, result);
      case CommandType::get: return get(request.message, result);
      case CommandType::undo: return undo(result);
      default: return save(result);
    }
  } catch (const std::exception& error) {
    reply.answer = Answer::failed;
    put(reply.text, error.what());
  }
}

void LiveParameters::describe(const Parameter& row, ReplyMessage& reply) const {
  put(reply.key, row.name());
  put(reply.value, row.get(config_));
  put(reply.standard, row.get(Config{}));
  put(reply.allowed, row.allowed());
  put(reply.unit, row.unit);
  reply.live = row.when == When::live;
  reply.index = static_cast<uint32_t>(&row - parameters().data());
}

void LiveParameters::set(const ParameterMessage& message, Result& result) {
  ReplyMessage& reply = result.message;
  std::string complaint;
  const Parameter* row = named_parameter(message.key, complaint);
  const auto refuse = [&](Answer why, std::string_view text) {
    reply.answer = why;
    put(reply.text, text);
  };
  if (!row) return refuse(Answer::unknown, complaint);
  const std::string before = row->get(config_);
  describe(*row, reply);
  Config changed = config_;
  complaint = change(changed, *row, message.value);
  if (!complaint.empty()) return refuse(Answer::refused, complaint);
  if (row->when == When::restart)
    return refuse(Answer::needs_restart, row->name() + " needs a restart: write it into vdisp.cfg and start vdispd again");
  config_ = std::move(changed);
  if (steps_.size() == most_steps) steps_.erase(steps_.begin());
  steps_.push_back({row, before});
  describe(*row, reply);
  result.changed = row;
  result.value = config_;
}

void LiveParameters::get(const ParameterMessage& message, Result& result) {
  ReplyMessage& reply = result.message;
  std::string complaint;
  const bool by_name = message.key[0] != 0;
  const Parameter* row = by_name                       ? named_parameter(message.key, complaint)
                         : message.index < reply.count ? &parameters()[message.index]
                                                       : nullptr;
  if (!row) {
    reply.answer = Answer::unknown;
    return put(reply.text, by_name ? complaint : "there are only " + std::to_string(reply.count) + " keys");
  }
  describe(*row, reply);
  put(reply.text, row->help);
}

/// The states before are gone through backwards, and each was checked as a whole.
void LiveParameters::undo(Result& result) {
  ReplyMessage& reply = result.message;
  if (steps_.empty()) {
    reply.answer = Answer::refused;
    return put(reply.text, "nothing to undo: no parameter was set since the start, or all is undone");
  }
  const Step step = std::move(steps_.back());
  steps_.pop_back();
  step.row->set(config_, step.before);
  describe(*step.row, reply);
  result.changed = step.row;
  result.value = config_;
}

/// What differs from the file: the values that set has changed for good.
std::vector<std::pair<const Parameter*, std::string>> LiveParameters::changes() const {
  std::vector<std::pair<const Parameter*, std::string>> values;
  for (const Parameter& row : parameters())
    if (row.get(saved_) != row.get(config_)) values.emplace_back(&row, row.get(config_));
  return values;
}

void LiveParameters::save(Result& result) {
  ReplyMessage& reply = result.message;
  const auto values = changes();
  std::string complaint;
  if (file_.empty()) {
    complaint = "the daemon was started without a vdisp.cfg: there is nothing to save to; start it with -c FILE";
  } else if (!values.empty()) {
    complaint = replace_config(file_, file_text_, rewritten(file_text_, values));
  }
  reply.answer = complaint.empty() ? Answer::done : Answer::failed;
  if (complaint.empty()) saved_ = config_;
  put(reply.value, file_.string());
  put(reply.text, complaint.empty() ? std::to_string(values.size()) + " changed keys" : complaint);
}

}  // namespace vdisp
