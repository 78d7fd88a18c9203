// upkeep.cpp: who is asked, told and fed between two frames.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/upkeep.h"

#include <algorithm>
#include <exception>
#include <utility>

#include "daemon/log/log.h"

namespace vdisp {

Upkeep::Upkeep(Driver& driver, Config& config, StereoSource& source, Inputs& inputs)
    : driver_(driver), config_(config), source_(source), inputs_(inputs) {
  recorder_.add_report(driver);
}

void Upkeep::begin(const ConfigOrigin& origin, const std::string& record, uint64_t epoch, bool serves, std::function<bool()> attachable) {
  control_.emplace(config_, origin, inputs_, serves,
                   [](std::string_view line, bool fault) { fault ? log::warn("{}", line) : log::info("{}", line); });
  report_.emplace(config_, source_, inputs_, *control_, recorder_.status());
  driver_.set_reporter([this](Health& health, const Catalogue& catalogue) { (*report_)(health, catalogue); });
  recorder_.start(record, driver_, config_, source_.calibration(), epoch, [this] { return control_->config_text(); });
  service_.emplace(config_, std::move(attachable));
}

void Upkeep::serve(bool flight_asked) {
  service_->expect(period_ns());
  for (std::string line; source_.news(line);) log::info("{}", line);
  if (flight_asked) recorder_.ask_flight();
  const int64_t period = std::max<int64_t>(source_.pair_period_ns(), config_.main.period * 1'000'000LL);
  driver_.set_deadline(static_cast<int64_t>(config_.main.deadline * 1e6), period);
  const bool changed = control_->serve(driver_.sequence());
  if (inputs_.recording_begins()) driver_.begin_anew();
  if (!changed) return;
  driver_.set_config_generation(control_->generation());
  log::set_level(config_.main.debug);
}

void Upkeep::see(const Topic& topic, const Image& image) noexcept {
  service_->see(topic, image);
  recorder_.see(topic, image);
}

void Upkeep::stepped(Outcome outcome) {
  service_->stepped(outcome, driver_, source_.fault());
  recorder_.finish_step();
}

void Upkeep::finish() {
  std::exception_ptr failure;
  try {
    recorder_.finish();
  } catch (const WriteError&) {
    failure = std::current_exception();
  }
  report_.reset();
  control_.reset();
  if (failure) std::rethrow_exception(failure);
}

int64_t Upkeep::period_ns() const { return std::max<int64_t>(source_.period_ns(), config_.main.period * 1'000'000LL); }

}  // namespace vdisp
