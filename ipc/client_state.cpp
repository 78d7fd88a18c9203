// client_state.cpp: keeps the connection, takes the newest images, judges them. Nothing here waits but service_until().
// SPDX-License-Identifier: Apache-2.0
#include "ipc/client_state.h"

#include <ctime>

#include "ipc/quiet.h"

namespace vdisp {
namespace {

constexpr int64_t alive_check_ns = 20'000'000;
constexpr int64_t full_retry_ns = 1'000'000'000;

}  // namespace

int64_t now_ns() {
  timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * 1'000'000'000LL + now.tv_nsec;
}

void sleep_until(int64_t at) {
  const timespec time{at / 1'000'000'000, at % 1'000'000'000};
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &time, nullptr);
}

bool possible_name(const std::string& name) { return !name.empty() && name.size() <= 100 && name.find(',') == std::string::npos; }

void Client::Implementation::lose(const std::string& why) {
  for (Slot& slot : slots) {
    slot.port.reset();  // nothing of the daemon's memory is touched
    slot.held[0] = slot.held[1] = {};
  }
  link.drop(why);
  asked = -1;
  beat = {};
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
  take(beats);
  if (!beats.held[0].image) return;
  const Image& newest = *beats.held[0].image;
  const auto* record = record_of<Heartbeat>(newest);
  if (!record) return;
  if (beat.epoch == 0) ++connections;
  beat = {newest.epoch, newest.ready_ns, std::clamp<int64_t>(record->period_ns, 0, 3'600'000'000'000)};
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
void Client::Implementation::take(Slot& slot) {
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
  const uint64_t size = chunk->userPayloadSize();
  const void* payload = chunk->userPayload();
  const Image* image = link.holds(payload, size) ? image_in(payload, size) : nullptr;
  if (!image) return nullptr;
  const bool kept = &slot == &slots[catalogue] || image->ready_ns >= slot.subscribed_ns - beat.patience(300'000'000);
  return kept ? image : nullptr;
}

Reading Client::Implementation::judge(const Image* image, int64_t now) const { return judged(image, connected() ? beat : Beat{}, now); }

Client::Implementation::Slot* Client::Implementation::find(Topic topic) {
  if (topic <= catalogue || topic >= static_cast<Topic>(slots.size()) || slots[topic].name.empty()) return nullptr;
  return &slots[topic];
}

}  // namespace vdisp
