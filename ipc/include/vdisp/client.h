// client.h: reads what vdispd publishes, and always says how far it can be trusted. For planners and viewers; C in client_c.h.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "vdisp/image.h"
#include "vdisp/records.h"

namespace vdisp {

/// How far the latest image of a topic can be trusted.
enum class Trust {
  fresh,  ///< valid and recent
  blind,  ///< recent, and the daemon says it cannot vouch: see Reading::reason
  stale,  ///< older, by ready_ns, than max(3 periods, 0.3 s): treat as unknown
  dead,   ///< no daemon: RouDi or the epoch is gone, or no heartbeat for max(1 s, 3 periods)
};

enum class Connection {
  connected,
  no_daemon,      ///< nothing to connect to (exit code 69)
  no_permission,  ///< not in the reader group (77)
  no_memory,      ///< the machine or iceoryx has no room for one more reader (71)
  wrong_name,     ///< no daemon can have the name that was asked for (64)
};

/// One look at one topic. `image` is read-only shared memory, checked (magic, version, kind and size), and stays valid until the next call
/// for the same topic, release(), or the loss of the daemon inside any call of this client: then the memory is gone.
/// Where image->flags has flag_synthetic it comes from the simulator or from files: do not drive by it.
struct Reading {
  const Image* image = nullptr;  ///< null: nothing has arrived yet from the daemon that is connected
  Trust trust = Trust::dead;
  Reason reason = Reason::none;  ///< why blind
  double age_s = 0;              ///< now - ready_ns
  bool fresh() const { return trust == Trust::fresh; }
};

/// One connection of this process to one daemon. At most one Client per process; not thread-safe. No call throws, aborts or waits
/// longer than its time limit (plus 50 ms); a daemon that ends or comes back is noticed inside the calls, which reconnect by themselves.
class Client {
 public:
  using Topic = int;
  using Time = std::chrono::milliseconds;

  /// `instance`: [main] name of the daemon. Does not wait for a daemon; see connection().
  explicit Client(std::string instance = "IPLObstacleDetection");
  ~Client();
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  /// Tries to connect if it is not connected, and waits for it as long as `limit`, which is at most 45 ms. `message()` says what is wrong
  /// and what would be right, in one line.
  Connection connection(Time limit = Time(45));
  const std::string& message() const;
  /// Waits until connected.
  bool wait_for_daemon(Time limit);

  /// Attaches to a topic by name; it need not exist yet. While attached the daemon computes it. An image older by more than
  /// max(3 periods, 0.3 s) than the subscription is not shown: an on-demand stage may have made it for a reader long gone.
  Topic subscribe(const std::string& topic);
  /// Detaches; the topic's number is free for reuse.
  void unsubscribe(Topic topic);

  /// The newest image, at once.
  Reading latest(Topic topic);
  /// The newest image, waiting for one newer than the last that this client returned for the topic. At the limit: what there is.
  Reading wait(Topic topic, Time limit);
  /// Waits for images of one and the same frame on all topics. False at the limit; `readings` then holds each topic's newest.
  bool wait_set(std::span<const Topic> topics, std::span<Reading> readings, Time limit);
  /// Gives the image back to the daemon's pool.
  void release(Topic topic);

  /// Start of the daemon that the client is connected to; 0: not connected. A change means: read everything anew.
  uint64_t epoch() const;
  /// Times a daemon was lost and found again.
  uint64_t reconnections() const;
  /// All topics that the daemon offers, in its order, as its catalogue (topic `catalogue`) last said; empty before the first.
  std::vector<CatalogueEntry> topics(Time limit);

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace vdisp
