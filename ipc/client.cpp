// client.cpp: the calls of the client library; what they stand on is in client_state.cpp and link.cpp.
// SPDX-License-Identifier: Apache-2.0
#include "ipc/include/vdisp/client.h"

#include <algorithm>
#include <atomic>

#include "ipc/client_state.h"
#include "ipc/quiet.h"

namespace vdisp {
namespace {

constexpr int64_t connect_budget_ns = 45'000'000;
std::atomic<bool> in_use{false};

}  // namespace

Client::Client(std::string instance) : implementation_(new Implementation) {
  Implementation& self = *implementation_;
  self.instance = std::move(instance);
  self.slots.resize(2);
  self.slots[Implementation::heartbeat].name = "heartbeat";
  self.slots[Implementation::catalogue].name = "catalogue";
  if (!possible_name(self.instance)) {
    self.message = "'" + self.instance + "' is no name of a daemon: 1 to 100 characters, no comma";
    return;
  }
  self.only = !in_use.exchange(true);
  if (!self.only) self.message = "this process has another vdisp::Client; one per process";
  if (!self.only) return;
  silence_iceoryx();
  count_errors();
  self.errors = counted_errors();
}

Client::~Client() {
  Implementation& self = *implementation_;
  if (!self.only) return;
  if (self.link.up() && self.link.alive()) {
    for (Implementation::Slot& slot : self.slots) self.close(slot);
  }
  in_use = false;
}

Connection Client::connection(Time limit) {
  Implementation& self = *implementation_;
  const int64_t now = now_ns();
  if (!self.only) return possible_name(self.instance) ? Connection::no_memory : Connection::wrong_name;
  self.service_until(now + std::min(connect_budget_ns, limit.count() * 1'000'000));
  if (self.link.up() && !self.connected()) {
    const bool starting = now - self.connected_ns < 2'000'000'000;
    self.message = starting ? "vdispd is starting: no heartbeat of '" + self.instance + "' yet"
                            : "RouDi is running, but nobody sends a heartbeat of '" + self.instance +
                                  "': is [main] name of vdispd another, or is it no vdispd?";
    return Connection::no_daemon;
  }
  self.message = self.link.message();
  return self.link.failure();
}

const std::string& Client::message() const { return implementation_->message; }

bool Client::wait_for_daemon(Time limit) {
  const int64_t deadline = now_ns() + limit.count() * 1'000'000;
  for (;;) {
    if (connection() == Connection::connected) return true;
    const int64_t now = now_ns();
    if (now >= deadline) return false;
    sleep_until(std::min(deadline, now + 10 * poll_ns));
  }
}

Client::Topic Client::subscribe(const std::string& topic) {
  Implementation& self = *implementation_;
  auto& slots = self.slots;
  size_t i = 2;
  while (i < slots.size() && (!slots[i].name.empty() || self.asked == static_cast<Topic>(i))) ++i;
  if (i == slots.size()) slots.emplace_back();
  slots[i].name = topic;
  self.service_until(now_ns() + connect_budget_ns);
  return static_cast<Topic>(i);
}

void Client::unsubscribe(Topic topic) {
  Implementation::Slot* slot = implementation_->find(topic);
  if (slot) implementation_->close(*slot);
}

Reading Client::latest(Topic topic) {
  Implementation& self = *implementation_;
  const int64_t now = now_ns();
  self.service(now);
  Implementation::Slot* slot = self.find(topic);
  if (!slot) return {};
  self.take(*slot);
  self.release(*slot, slot->held[1]);
  if (slot->held[0].image) slot->returned = identity(*slot->held[0].image);
  return self.judge(slot->held[0].image, now);
}

Reading Client::wait(Topic topic, Time limit) {
  Implementation& self = *implementation_;
  const int64_t deadline = now_ns() + limit.count() * 1'000'000;
  for (;;) {
    const int64_t now = now_ns();
    self.service(now);
    Implementation::Slot* slot = self.find(topic);
    if (slot) self.take(*slot);
    const bool newer = slot && slot->held[0].image && identity(*slot->held[0].image) != slot->returned;
    if (newer || now >= deadline) return latest(topic);
    sleep_until(std::min(deadline, now + poll_ns));
  }
}

bool Client::wait_set(std::span<const Topic> topics, std::span<Reading> readings, Time limit) {
  Implementation& self = *implementation_;
  const size_t count = std::min(topics.size(), readings.size());
  const int64_t deadline = now_ns() + limit.count() * 1'000'000;
  std::vector<Implementation::Held*> choice(count);
  for (;;) {
    const int64_t now = now_ns();
    self.service(now);
    for (size_t i = 0; i < count; ++i) {
      if (auto* slot = self.find(topics[i])) self.take(*slot);
    }
    auto* first = count > 0 ? self.find(topics[0]) : nullptr;
    for (auto& candidate : first ? std::span(first->held) : std::span<Implementation::Held>()) {
      if (!candidate.image || identity(*candidate.image) == first->returned) break;  // newest first: none of these is newer
      bool complete = true;
      for (size_t i = 0; i < count && complete; ++i) {
        auto* slot = self.find(topics[i]);
        choice[i] = nullptr;
        for (auto& held : slot ? std::span(slot->held) : std::span<Implementation::Held>()) {
          if (held.image && held.image->sequence == candidate.image->sequence && held.image->epoch == candidate.image->epoch)
            choice[i] = &held;
        }
        complete = choice[i] != nullptr;
      }
      if (!complete) continue;
      for (size_t i = 0; i < count; ++i) {
        readings[i] = self.judge(choice[i]->image, now);
        self.find(topics[i])->returned = identity(*choice[i]->image);
      }
      return true;
    }
    if (now >= deadline) break;
    sleep_until(std::min(deadline, now + poll_ns));
  }
  for (size_t i = 0; i < count; ++i) {
    auto* slot = self.find(topics[i]);
    readings[i] = slot ? self.judge(slot->held[0].image, now_ns()) : Reading{};
  }
  return false;
}

void Client::release(Topic topic) {
  Implementation& self = *implementation_;
  Implementation::Slot* slot = self.find(topic);
  if (!slot) return;
  self.release(*slot, slot->held[0]);
  self.release(*slot, slot->held[1]);
}

uint64_t Client::epoch() const { return implementation_->connected() ? implementation_->beat.epoch : 0; }

uint64_t Client::reconnections() const { return implementation_->connections > 0 ? implementation_->connections - 1 : 0; }

std::vector<CatalogueEntry> Client::topics(Time limit) {
  Implementation& self = *implementation_;
  const int64_t deadline = now_ns() + limit.count() * 1'000'000;
  Implementation::Slot& slot = self.slots[Implementation::catalogue];
  for (;;) {
    const int64_t now = now_ns();
    self.service(now);
    self.take(slot);
    if (slot.held[0].image || now >= deadline) break;
    sleep_until(std::min(deadline, now + poll_ns));
  }
  self.release(slot, slot.held[1]);
  const auto* catalogue = slot.held[0].image ? record_of<Catalogue>(*slot.held[0].image) : nullptr;
  return catalogue ? entries_of(*catalogue) : std::vector<CatalogueEntry>();
}

}  // namespace vdisp
