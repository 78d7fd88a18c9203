// log.cpp: spdlog set up once.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/log/log.h"

#include <spdlog/async.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_sinks.h>

#include <cstdlib>

namespace vdisp::log {
namespace {

constexpr size_t ring_lines = 1024;

/// journald's priority in front of the line, <3> to <7> (sd-daemon(3)).
class Priority final : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message, const std::tm&, spdlog::memory_buf_t& to) override {
    const char* priority = message.level >= spdlog::level::err    ? "<3>"
                           : message.level == spdlog::level::warn ? "<4>"
                           : message.level == spdlog::level::info ? "<6>"
                                                                  : "<7>";
    to.append(priority, priority + 3);
  }
  std::unique_ptr<custom_flag_formatter> clone() const override { return std::make_unique<Priority>(); }
};

constexpr spdlog::level::level_enum levels[] = {spdlog::level::err, spdlog::level::info, spdlog::level::debug, spdlog::level::trace};

}  // namespace

void start(int level, const std::string& program) {
  spdlog::init_thread_pool(ring_lines, 1);
  auto logger = std::make_shared<spdlog::async_logger>(program, std::make_shared<spdlog::sinks::stderr_sink_mt>(), spdlog::thread_pool(),
                                                       spdlog::async_overflow_policy::overrun_oldest);
  auto formatter = std::make_unique<spdlog::pattern_formatter>();
  formatter->add_flag<Priority>('*').set_pattern(std::getenv("JOURNAL_STREAM") ? "%*%v" : "%n: %v");
  logger->set_formatter(std::move(formatter));
  logger->set_level(levels[level]);
  spdlog::set_default_logger(std::move(logger));
}

void set_level(int level) { spdlog::default_logger_raw()->set_level(levels[level]); }

uint64_t lines_lost() {
  const auto pool = spdlog::thread_pool();
  return pool ? pool->overrun_counter() : 0;
}

void stop() { spdlog::shutdown(); }

}  // namespace vdisp::log
