// client.cpp: keeps the connection, takes the newest images, judges them.
// SPDX-License-Identifier: Apache-2.0
#include "ipc/include/vdisp/client.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <ctime>

#include "ipc/link.h"
#include "ipc/quiet.h"

namespace vdisp {
namespace {

// Asked this often whether something new is there. iceoryx could wake us instead, but by a lock in shared memory: a reader
// that is stopped or killed inside it would stop the daemon.
constexpr int64_t poll_ns = 1'000'000;
constexpr int64_t alive_check_ns = 20'000'000;
constexpr int64_t connect_budget_ns = 45'000'000;
constexpr int64_t full_retry_ns = 1'000'000'000;

int64_t now_ns() {
  timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * 1'000'000'000LL + now.tv_nsec;
}

void sleep_until(int64_t at) {
  const timespec time{at / 1'000'000'000, at % 1'000'000'000};
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &time, nullptr);
}

std::atomic<bool> in_use{false};

/// iceoryx separates the parts of a message by commas and cuts names at 100 characters.
bool possible_name(const std::string& name) { return !name.empty() && name.size() <= 100 && name.find(',') == std::string::npos; }

/// What tells one image of a topic from another.
struct Identity {
  uint64_t epoch = 0, sequence = 0;
  int64_t ready_ns = 0;
  bool operator==(const Identity&) const = default;
};
Identity identity(const Image& image) { return {image.epoch, image.sequence, image.ready_ns}; }

}  // namespace

struct Client::Implementation {
  using Chunk = const iox::mepoo::ChunkHeader*;
  struct Held {
    Chunk chunk = nullptr;
    const Image* image = nullptr;
  };
  struct Slot {
    std::string name;  // empty: free for reuse
    std::unique_ptr<Link::Port> port;
    int64_t subscribed_ns = 0, retry_ns = 0;
    Held held[2];  // newest first
    Identity returned;
  };
  static constexpr Topic heartbeat = 0, catalogue = 1;

  std::string instance;
  bool only = false;  // the one client of this process
  Link link;
  std::vector<Slot> slots;
  Topic asked = -1;  // whose port was asked for
  std::string message;
  int64_t checked_ns = 0, connected_ns = 0, beat_ns = 0, period_ns = 0;
  uint64_t epoch = 0, connections = 0, errors = 0;

  bool connected() const { return link.up() && epoch != 0; }
  void lose(const std::string& why);
  void service(int64_t now);
  void ask_ports(int64_t now);
  void service_until(int64_t deadline);
  void take(Slot& slot, int64_t now);
  const Image* accept(Chunk chunk, const Slot& slot) const;
  void release(Slot& slot, Held& held) const;
  void close(Slot& slot);
  Reading judge(const Image* image, int64_t now) const;
  Slot* find(Topic topic);
  int64_t patience(int64_t least) const { return std::max(3 * period_ns, least); }
};

void Client::Implementation::lose(const std::string& why) {
  for (Slot& slot : slots) {
    slot.port.reset();  // nothing of the daemon's memory is touched
    slot.held[0] = slot.held[1] = {};
  }
  link.drop(why);
  asked = -1;
  epoch = 0;
  beat_ns = period_ns = 0;
}

/// Everything that has to happen between two looks at the images; never waits.
void Client::Implementation::service(int64_t now) {
  if (!only) return;
  if (counted_errors() != errors) {
    errors = counted_errors();
    if (link.up()) lose("iceoryx reported an error; connecting anew");
  }
  if (link.up() && now - checked_ns >= alive_check_ns) {
    checked_ns = now;
    if (!link.alive()) lose("vdispd has ended");
  }
  if (!link.up()) {
    if (!link.advance(now)) return;
    checked_ns = connected_ns = now;
  }
  ask_ports(now);
  if (!link.up()) return;
  Slot& beats = slots[heartbeat];
  take(beats, now);
  if (!beats.held[0].image) return;
  const auto* beat = record_of<Heartbeat>(*beats.held[0].image);
  if (!beat) return;
  if (epoch == 0) ++connections;
  epoch = beats.held[0].image->epoch;
  beat_ns = beats.held[0].image->ready_ns;
  period_ns = std::clamp<int64_t>(beat->period_ns, 0, 3'600'000'000'000);
}

void Client::Implementation::ask_ports(int64_t now) {
  if (asked >= 0) {
    auto port = link.port(now);
    if (!link.up()) return lose(link.message());
    if (link.busy()) return;
    Slot& slot = slots[asked];
    asked = -1;
    if (port && slot.name.empty())
      port->destroy();  // unsubscribed while it was under way
    else if (port)
      slot.port = std::make_unique<Link::Port>(std::move(*port));
    else
      slot.retry_ns = now + full_retry_ns;
  }
  for (size_t i = 0; i < slots.size(); ++i) {
    Slot& slot = slots[i];
    if (!possible_name(slot.name) || slot.port || now < slot.retry_ns) continue;
    slot.subscribed_ns = now;
    link.ask_port(instance, slot.name, now);
    if (!link.up()) return lose(link.message());
    asked = static_cast<Topic>(i);
    return;
  }
}

void Client::Implementation::service_until(int64_t deadline) {
  for (int64_t now = now_ns();; now = now_ns()) {
    service(now);
    const bool settled = connected() && asked < 0;
    const bool hopeless = !link.up() && !link.registering();
    if (settled || hopeless || now >= deadline) return;
    sleep_until(now + poll_ns / 4);
  }
}

void Client::Implementation::release(Slot& slot, Held& held) const {
  if (held.chunk && slot.port) slot.port->releaseChunk(held.chunk);
  held = {};
}

void Client::Implementation::close(Slot& slot) {
  release(slot, slot.held[0]);
  release(slot, slot.held[1]);
  if (slot.port) slot.port->destroy();
  slot = {};
}

/// Takes all that has arrived and keeps the two newest.
void Client::Implementation::take(Slot& slot, int64_t) {
  if (!slot.port) return;
  while (slot.port->hasNewChunks()) {
    auto taken = slot.port->tryGetChunk();
    if (taken.has_error()) return;
    const Image* image = accept(taken.value(), slot);
    if (!image) {
      slot.port->releaseChunk(taken.value());
      continue;
    }
    release(slot, slot.held[1]);
    slot.held[1] = slot.held[0];
    slot.held[0] = {taken.value(), image};
  }
}

/// The image in a chunk, or null where it is not one, or older than the subscription: what an on-demand stage made for a reader
/// that is long gone.
const Image* Client::Implementation::accept(Chunk chunk, const Slot& slot) const {
  const auto* image = static_cast<const Image*>(chunk->userPayload());
  const uint64_t size = chunk->userPayloadSize();
  if (reinterpret_cast<uintptr_t>(image) % alignof(Image) != 0 || size < sizeof(Image) || !link.holds(image, size)) return nullptr;
  if (image->magic != Image::magic_value || image->version != Image::version_value) return nullptr;
  if (sizeof(Image) + static_cast<uint64_t>(image->spec.stride()) * image->spec.height > size) return nullptr;
  if (static_cast<uint32_t>(image->reason) >= static_cast<uint32_t>(Reason::count)) return nullptr;
  const bool kept = &slot == &slots[catalogue] || image->ready_ns >= slot.subscribed_ns - patience(300'000'000);
  return kept ? image : nullptr;
}

Reading Client::Implementation::judge(const Image* image, int64_t now) const {
  Reading reading;
  reading.image = image;
  if (image) {
    reading.age_s = static_cast<double>(now - image->ready_ns) * 1e-9;
    reading.reason = image->reason;
  }
  if (!connected() || now - beat_ns > patience(1'000'000'000) || (image && image->epoch != epoch))
    reading.trust = Trust::dead;
  else if (!image || now - image->ready_ns > patience(300'000'000))
    reading.trust = Trust::stale;
  else
    reading.trust = image->valid() ? Trust::fresh : Trust::blind;
  return reading;
}

Client::Implementation::Slot* Client::Implementation::find(Topic topic) {
  if (topic <= catalogue || topic >= static_cast<Topic>(slots.size()) || slots[topic].name.empty()) return nullptr;
  return &slots[topic];
}

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

Connection Client::connection() {
  Implementation& self = *implementation_;
  const int64_t now = now_ns();
  if (!self.only) return Connection::no_memory;
  self.service_until(now + connect_budget_ns);
  if (self.link.up() && !self.connected()) {
    self.message = "the RouDi that is running sends no heartbeat of '" + self.instance +
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
  self.take(*slot, now);
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
    if (slot) self.take(*slot, now);
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
      if (auto* slot = self.find(topics[i])) self.take(*slot, now);
    }
    auto* first = count > 0 ? self.find(topics[0]) : nullptr;
    for (auto& candidate : first ? std::span(first->held) : std::span<Implementation::Held>()) {
      if (!candidate.image || identity(*candidate.image) == first->returned) break;  // newest first: none of these is newer
      bool complete = true;
      for (size_t i = 0; i < count && complete; ++i) {
        auto* slot = self.find(topics[i]);
        choice[i] = nullptr;
        for (auto& held : slot ? std::span(slot->held) : std::span<Implementation::Held>()) {
          if (held.image && held.image->sequence == candidate.image->sequence && held.image->epoch == candidate.image->epoch) choice[i] = &held;
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

uint64_t Client::epoch() const { return implementation_->connected() ? implementation_->epoch : 0; }

uint64_t Client::reconnections() const { return implementation_->connections > 0 ? implementation_->connections - 1 : 0; }

std::vector<CatalogueEntry> Client::topics(Time limit) {
  Implementation& self = *implementation_;
  const int64_t deadline = now_ns() + limit.count() * 1'000'000;
  Implementation::Slot& slot = self.slots[Implementation::catalogue];
  for (;;) {
    const int64_t now = now_ns();
    self.service(now);
    self.take(slot, now);
    if (slot.held[0].image || now >= deadline) break;
    sleep_until(std::min(deadline, now + poll_ns));
  }
  self.release(slot, slot.held[1]);
  const auto* catalogue = slot.held[0].image ? record_of<Catalogue>(*slot.held[0].image) : nullptr;
  if (!catalogue) return {};
  const uint32_t count = std::min(catalogue->count, Catalogue::capacity);
  std::vector<CatalogueEntry> entries(catalogue->entries, catalogue->entries + count);
  for (CatalogueEntry& entry : entries) {
    entry.name[sizeof entry.name - 1] = 0;
    for (int16_t& parent : entry.parents) {
      if (parent < -1 || parent >= static_cast<int>(count)) parent = -1;
    }
  }
  return entries;
}

}  // namespace vdisp
