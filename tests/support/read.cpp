// read.cpp: readers as they should be and as they should not, for the system tests.
// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <thread>
#include <vector>

#include "daemon/core/clock.h"
#include "ipc/endpoint.h"
#include "vdisp/client.h"

using namespace vdisp;
using std::chrono::milliseconds;

namespace {

/// Notices when this process is not run although it would: the processor is given to others, or the whole machine stands still.
class Pulse {
 public:
  /// The longest that it was not run since this was last asked, ns.
  int64_t longest_gap() noexcept { return std::max(gap_.exchange(0), monotonic_ns() - beat_.load()); }

 private:
  std::atomic<int64_t> beat_{monotonic_ns()}, gap_{0};
  std::jthread thread_{[this](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      std::this_thread::sleep_for(milliseconds(4));
      const int64_t now = monotonic_ns();
      const int64_t gap = now - beat_.exchange(now);
      for (int64_t longest = gap_; gap > longest && !gap_.compare_exchange_weak(longest, gap);) {
      }
    }
  }};
};

/// Sees every frame, and says how many it did not see: `missed`, and apart from these `asleep`: no more than came while it was not run.
int count(Client& client, const std::string& topic, double seconds) {
  const int64_t end = monotonic_ns() + static_cast<int64_t>(seconds * 1e9);
  const Client::Topic handle = client.subscribe(topic);
  uint64_t frames = 0, missed = 0, asleep = 0, last = 0, epoch = 0;
  int64_t last_taken = 0;
  std::vector<double> ages;
  Pulse pulse;
  while (monotonic_ns() < end) {
    const Reading reading = client.wait(handle, milliseconds(200));
    if (!reading.image || (reading.image->sequence == last && reading.image->epoch == epoch)) continue;
    const uint64_t gap = epoch == reading.image->epoch ? reading.image->sequence - last - 1 : 0;
    const int64_t not_run = pulse.longest_gap(), period = (reading.image->timestamp_ns - last_taken) / static_cast<int64_t>(gap + 1);
    const uint64_t came = not_run > 20'000'000 && period > 0 ? static_cast<uint64_t>(not_run / period) + 1 : 0;
    asleep += std::min(gap, came);
    missed += gap - std::min(gap, came);
    last_taken = reading.image->timestamp_ns;
    epoch = reading.image->epoch;
    last = reading.image->sequence;
    ++frames;
    ages.push_back(reading.age_s * 1e6);
  }
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  const double cpu = static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
                     static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec) * 1e-6;
  std::sort(ages.begin(), ages.end());
  const auto percentile = [&](double p) { return ages.empty() ? 0 : ages[static_cast<size_t>(p * static_cast<double>(ages.size() - 1))]; };
  std::printf("frames %llu missed %llu asleep %llu reconnections %llu age_us p50 %.0f p99 %.0f cpu %.1f%%\n",
              static_cast<unsigned long long>(frames), static_cast<unsigned long long>(missed), static_cast<unsigned long long>(asleep),
              static_cast<unsigned long long>(client.reconnections()), percentile(0.5), percentile(0.99), 100 * cpu / seconds);
  return 0;
}

/// Takes `number` images by as many subscriptions and never gives one back.
int hold(Client& client, const std::string& topic, int number, double seconds) {
  for (int i = 0; i < number; ++i) {
    const Client::Topic handle = client.subscribe(topic);
    for (int twice = 0; twice < 2; ++twice) client.wait(handle, milliseconds(100));  // the first may be the one before's
  }
  std::printf("holding\n");
  std::fflush(stdout);
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
  return 0;
}

int sets(Client& client, int number) {
  const Client::Topic topics[] = {client.subscribe("left"), client.subscribe("map"), client.subscribe("copy")};
  Reading readings[3];
  int complete = 0, wrong = 0;
  uint64_t last = 0;
  for (int i = 0; i < number; ++i) {
    if (!client.wait_set(topics, readings, milliseconds(1000))) continue;
    ++complete;
    const uint64_t sequence = readings[0].image->sequence;
    if (sequence != readings[1].image->sequence || sequence != readings[2].image->sequence || sequence <= last) ++wrong;
    // The pixels too are of that frame: no block was written while it was read.
    if (*readings[2].image->row<uint8_t>(479) != (sequence & 255) || *readings[0].image->row<uint8_t>(0) != (sequence & 255)) ++wrong;
    last = sequence;
  }
  std::printf("sets %d wrong %d\n", complete, wrong);
  return wrong == 0 && complete >= number - 2 ? 0 : 1;
}

/// The time in the first row of what vdisp-gige-camera sends: 64 pixels, 0 or 255 or near it.
int64_t stamp(const Image& image) {
  uint64_t time = 0;
  for (int bit = 0; bit < 64; ++bit) time |= static_cast<uint64_t>(image.row<uint8_t>(0)[bit] > 100) << bit;
  return static_cast<int64_t>(time);
}

/// Frames of a camera that are neither in a pair nor counted as anything else: those that wait for their other half.
long long over(const CameraStatus& status, int side) {
  const CameraView& view = status.view[side];
  return static_cast<long long>(view.frames) - static_cast<long long>(view.refused + view.unpaired + status.pairs);
}

/// What left and right say themselves of when they were taken: more than `most_ms` apart is no pair.
int pairs(Client& client, double seconds, double most_ms) {
  const int64_t end = monotonic_ns() + static_cast<int64_t>(seconds * 1e9);
  const Client::Topic topics[] = {client.subscribe("camera/left"), client.subscribe("camera/right"), client.subscribe("camera/status")};
  Reading readings[3];
  uint64_t number = 0, blind = 0, missed = 0, mismatched = 0, older = 0, last = 0;
  int64_t last_stamp = 0;
  double worst_ms = 0;
  CameraStatus status{};
  while (monotonic_ns() < end) {
    if (!client.wait_set(topics, readings, milliseconds(200))) continue;
    const uint64_t sequence = readings[0].image->sequence;
    if (last && sequence > last + 1) missed += sequence - last - 1;
    last = sequence;
    if (const CameraStatus* told = record_of<CameraStatus>(*readings[2].image)) status = *told;
    if (!readings[0].image->valid() || !readings[1].image->valid()) {
      ++blind;
      continue;
    }
    const int64_t left = stamp(*readings[0].image), right = stamp(*readings[1].image);
    const double apart_ms = static_cast<double>(std::llabs(left - right)) * 1e-6;
    worst_ms = std::max(worst_ms, apart_ms);
    mismatched += apart_ms > most_ms;
    older += left <= last_stamp;
    last_stamp = left;
    ++number;
  }
  const auto u = [](uint64_t value) { return static_cast<unsigned long long>(value); };
  std::printf(
      "pairs %llu blind %llu missed %llu mismatched %llu older %llu worst_ms %.3f skipped %llu incomplete %llu unpaired %llu opened %u "
      "formed %llu left_over %lld right_over %lld\n",
      u(number), u(blind), u(missed), u(mismatched), u(older), worst_ms, u(status.skipped),
      u(status.view[0].incomplete + status.view[1].incomplete), u(status.view[0].unpaired + status.view[1].unpaired),
      status.view[0].opened + status.view[1].opened, u(status.pairs), over(status, 0), over(status, 1));
  return 0;
}

/// One line on every change of state, with the time and why.
int watch(Client& client, double seconds, const std::string& topic) {
  const int64_t end = monotonic_ns() + static_cast<int64_t>(seconds * 1e9);
  const char* const words[] = {"fresh", "blind", "stale", "dead"};
  const Client::Topic handle = client.subscribe(topic);
  int last = -1;
  Reason why = Reason::none;
  while (monotonic_ns() < end) {
    const Reading reading = client.wait(handle, milliseconds(50));
    if (static_cast<int>(reading.trust) == last && reading.reason == why) continue;
    last = static_cast<int>(reading.trust);
    why = reading.reason;
    std::printf("%s %lld %s\n", words[last], static_cast<long long>(monotonic_ns()), name(why).data());
    std::fflush(stdout);
  }
  return 0;
}

/// Serves RouDi's socket and never answers.
int impostor(double seconds) {
  const int fd = socket(AF_LOCAL, SOCK_DGRAM, 0);
  const sockaddr_un address = socket_address(roudi_socket);
  unlink(roudi_socket);
  if (bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) return 1;
  close(open(management_segment, O_RDWR | O_CREAT, 0600));
  if (truncate(management_segment, 4096) != 0) return 1;
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
  return 0;
}

int connect_once(Client& client, double seconds) {
  const int64_t start = monotonic_ns();
  const bool connected = client.wait_for_daemon(milliseconds(static_cast<int>(seconds * 1e3)));
  std::printf("%s after %.3f s: %s\n", connected ? "connected" : "not connected", static_cast<double>(monotonic_ns() - start) * 1e-9,
              client.message().c_str());
  const int code[] = {0, 69, 77, 71, 64};
  return connected ? 0 : code[static_cast<int>(client.connection())];
}

/// What a reader of images must not be able to do: ends by a fault.
int write_image(Client& client) {
  const Reading reading = client.wait(client.subscribe("map"), milliseconds(1000));
  if (!reading.image) return 1;
  const_cast<Image*>(reading.image)->sequence = 0;
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string word = argc > 1 ? argv[1] : "";
  const auto number = [&](int i, double otherwise) { return argc > i ? std::atof(argv[i]) : otherwise; };
  const std::string topic = argc > 2 ? argv[2] : "map";
  if (word == "impostor") return impostor(number(2, 1));
  Client client;
  if (word == "count") return count(client, topic, number(3, 5));
  if (word == "hold") return hold(client, topic, static_cast<int>(number(3, 24)), number(4, 5));
  if (word == "sets") return sets(client, static_cast<int>(number(2, 50)));
  if (word == "pairs") return pairs(client, number(2, 5), number(3, 10));
  if (word == "watch") return watch(client, number(2, 5), argc > 3 ? argv[3] : "map");
  if (word == "connect") return connect_once(client, number(2, 1));
  if (word == "write") return write_image(client);
  return 64;
}
