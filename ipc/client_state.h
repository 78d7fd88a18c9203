// client_state.h: what a client keeps between two calls: the connection, its subscriptions, the images it holds.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "ipc/include/vdisp/client.h"
#include "ipc/link.h"
#include "ipc/received.h"

namespace vdisp {

// Asked this often whether something new is there. iceoryx could wake us instead, but by a lock in shared memory: a reader
// that is stopped or killed inside it would stop the daemon.
inline constexpr int64_t poll_ns = 1'000'000;

int64_t now_ns();
void sleep_until(int64_t at_ns);
/// iceoryx separates the parts of a message by commas and cuts names at 100 characters.
bool possible_name(const std::string& name);

/// What tells one image of a topic from another.
struct Identity {
  uint64_t epoch = 0, sequence = 0;
  int64_t ready_ns = 0;
  bool operator==(const Identity&) const = default;
};
inline Identity identity(const Image& image) { return {image.epoch, image.sequence, image.ready_ns}; }

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
  int64_t checked_ns = 0, connected_ns = 0;
  Beat beat;
  uint64_t connections = 0, errors = 0;

  bool connected() const { return link.up() && beat.epoch != 0; }
  void lose(const std::string& why);
  void service(int64_t now);
  void ask_ports(int64_t now);
  void service_until(int64_t deadline);
  void take(Slot& slot);
  const Image* accept(Chunk chunk, const Slot& slot) const;
  void release(Slot& slot, Held& held) const;
  void close(Slot& slot);
  Reading judge(const Image* image, int64_t now) const;
  Slot* find(Topic topic);
};

}  // namespace vdisp
