// live_parameters.cpp: the thread that answers, and the loop's end of it; what changes anything is in parameter_changes.cpp.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/control/live_parameters.h"

#include <chrono>
#include <sstream>
#include <string_view>

#include "config/change.h"
#include "daemon/control/config_file.h"
#include "daemon/control/reply_text.h"
#include "daemon/core/background.h"

namespace vdisp {
namespace {

constexpr size_t waiting = 64;  // requests, of all clients together
constexpr int slide_ms = 1000;  // a slider that rests so long has arrived
constexpr int longest_wait_ms = 3600'000;

}  // namespace

LiveParameters::LiveParameters(Config& config, ConfigOrigin origin, Tell tell)
    : in_use_(config),
      config_(config),
      saved_(config),
      origin_(std::move(origin)),
      tell_(std::move(tell)),
      requests_(waiting),
      results_(waiting),
      watch_(origin_.file, origin_.watched) {
  if (!origin_.file.empty()) file_text_ = seen_text_ = read_text(origin_.file).value_or("");
  if (!watch_.trouble().empty()) tell_(watch_.trouble(), true);
  write_text();
  thread_ = std::thread([this] { think(); });
}

LiveParameters::~LiveParameters() {
  ending_ = true;
  watch_.ask();
  thread_.join();
}

bool LiveParameters::ask(const ParameterMessage& message, const Sender& sender) noexcept {
  Request* place = requests_.free_place();
  if (!place) return false;
  place->message = message;
  place->sender = sender;
  requests_.push();
  watch_.ask();
  return true;
}

bool LiveParameters::next(Reply& reply) noexcept {
  Result* result = results_.front();
  if (!result) return false;
  for (const Parameter* row : result->changed) row->exchange(in_use_, result->value);
  if (!result->changed.empty()) ++generation_;
  result->message.config_generation = generation_;
  reply = {result->client, &result->message};
  return true;
}

void LiveParameters::think() {
  begin_in_background("parameters");
  while (true) {
    const ConfigWatch::Event event = watch_.wait(slide_.row ? slide_ms : longest_wait_ms);
    if (ending_) break;
    try {
      hear(event);
    } catch (const std::exception& error) {  // no memory: the next time, perhaps
      tell_(std::string("parameters: ") + error.what(), true);
    }
  }
  tell_slide();
}

std::string LiveParameters::text() const {
  const std::lock_guard lock(text_mutex_);
  return text_;
}

void LiveParameters::write_text() {
  std::ostringstream printed;
  print_config(printed, config_);
  const std::lock_guard lock(text_mutex_);
  text_ = printed.str();
}

void LiveParameters::hear(ConfigWatch::Event event) {
  switch (event) {
    case ConfigWatch::Event::nothing: return tell_slide();
    case ConfigWatch::Event::asked: answer_all(); break;
    case ConfigWatch::Event::hangup: reload(Precedence::file, "SIGHUP" + sent_by(watch_.pid(), watch_.uid())); break;
    case ConfigWatch::Event::changed: reload(Precedence::hand, "the file was changed"); break;
  }
  write_text();
}

/// The loop takes results faster than it asks: a place becomes free. Sleeping is as good as anything. Null: the daemon ends.
LiveParameters::Result* LiveParameters::free_result() {
  Result* result = results_.free_place();
  while (!result && !ending_) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    result = results_.free_place();
  }
  if (result) {
    result->client = 0;
    result->changed.clear();
    result->message = {};
  }
  return result;
}

void LiveParameters::answer_all() {
  while (Request* request = requests_.front()) {
    Result* result = free_result();
    if (!result) return;
    answer(*request, *result);
    requests_.pop();
    results_.push();
  }
}

void LiveParameters::answer(const Request& request, Result& result) {
  result.client = request.sender.connection;
  ReplyMessage& reply = result.message;
  reply.header = {command_magic, command_version, CommandType::reply, sizeof reply, request.message.header.number};
  reply.count = static_cast<uint32_t>(parameters().size());
  try {
    switch (request.message.header.type) {
      case CommandType::set: return set(request, result);
      case CommandType::get: return get(request.message, result);
      case CommandType::undo: return undo(request.sender, result);
      default: return save(request.sender, result);
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

}  // namespace vdisp
