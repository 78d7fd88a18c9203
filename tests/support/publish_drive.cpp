// publish_drive.cpp: a daemon for the tests of vdisp-drive: real driver, real shared memory, orders as its standard input says.
// SPDX-License-Identifier: Apache-2.0
//   publish_drive [--rate HZ]; lines in: go SPEED TURN | blind | silent (lives, and gives no orders) | synthetic | real | rate HZ | end
//   A line out for each that took effect: its CLOCK_MONOTONIC in ns and the line. `silent` is told the moment of the last order.
#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <limits>
#include <string>

#include "daemon/core/clock.h"
#include "daemon/core/driver.h"
#include "ipc/shm.h"

using namespace vdisp;

namespace {

/// What standard input said last.
struct Said {
  double speed = 0, turn = 0, rate = 30;
  bool blind = false, silent = false, synthetic = false, ended = false;
} said;

struct Decide final : ImageSource {
  std::vector<ImageSpec> open() override { return {record_spec<DriveCommand>()}; }
  Outcome grab(std::span<Image* const> out) noexcept override {
    out[0]->timestamp_ns = monotonic_ns();
    out[0]->flags = said.synthetic ? uint32_t{flag_synthetic} : 0;
    DriveCommand& command = make_record<DriveCommand>(*out[0]);
    command.speed = said.speed;
    command.turn_rate = said.turn;
    command.decider = Decider::vdisparity;
    if (!said.blind) return Outcome::valid;
    out[0]->reason = Reason::too_dark;
    return Outcome::invalid;
  }
};

void obey(const std::string& line) {
  char word[16] = "", first[32] = "", second[32] = "";
  std::sscanf(line.c_str(), "%15s %31s %31s", word, first, second);
  const std::string what = word;
  if (what == "go") said.speed = std::strtod(first, nullptr), said.turn = std::strtod(second, nullptr);  // strtod knows nan and inf
  if (what == "go" || what == "blind") said.blind = what == "blind", said.silent = false;
  if (what == "silent") said.silent = true;
  if (what == "synthetic" || what == "real") said.synthetic = what == "synthetic";
  if (what == "rate") said.rate = std::strtod(first, nullptr);
  if (what == "end") said.ended = true;
}

/// The next line of standard input, waiting for it until the moment; empty: none.
std::string line_until(int64_t until_ns) {
  static std::string buffer;
  for (;;) {
    const size_t end = buffer.find('\n');
    if (end != std::string::npos) {
      std::string line = buffer.substr(0, end);
      buffer.erase(0, end + 1);
      return line;
    }
    const int64_t left = until_ns - monotonic_ns();
    pollfd input{STDIN_FILENO, POLLIN, 0};
    if (poll(&input, 1, left > 0 ? static_cast<int>(left / 1'000'000) : 0) <= 0) return {};
    char bytes[256];
    const ssize_t count = read(STDIN_FILENO, bytes, sizeof bytes);
    if (count <= 0) return "end";
    buffer.append(bytes, static_cast<size_t>(count));
  }
}

void tell(int64_t at_ns, const std::string& line) {
  std::printf("%lld %s\n", static_cast<long long>(at_ns), line.c_str());
  std::fflush(stdout);
}

int run() {
  Driver driver(wall_clock_ns());
  driver.add("drive", std::make_unique<Decide>(), {}, Need::always);
  TopicList topics;
  for (const Topic& topic : driver.published_topics()) topics.emplace_back(topic.name, topic.spec);
  SharedMemory memory({"IPLObstacleDetection", "", 64}, topics);
  driver.connect([&](const std::string& topic, const ImageSpec& spec) { return memory.outlet(topic, spec); });
  tell(monotonic_ns(), "ready");
  int64_t due = monotonic_ns(), ordered_ns = 0;
  while (!said.ended) {
    if (!said.silent) {
      driver.step();
      ordered_ns = monotonic_ns();
    }
    driver.beat();
    due = std::max(due + static_cast<int64_t>(1e9 / said.rate), monotonic_ns());
    for (std::string line = line_until(due); !line.empty() || monotonic_ns() < due; line = line_until(due)) {
      if (line.empty()) continue;
      obey(line);
      if (said.ended) break;
      if (!said.silent) driver.step();
      driver.beat();
      if (!said.silent) ordered_ns = monotonic_ns();
      tell(said.silent ? ordered_ns : monotonic_ns(), line);
    }
  }
  SharedMemory::leave(0);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 3 && std::string(argv[1]) == "--rate") said.rate = std::strtod(argv[2], nullptr);
  try {
    return run();
  } catch (const ShmError& error) {
    std::cerr << error.what() << '\n';
    SharedMemory::leave(error.exit_code);
  }
}
