// publish.cpp: a daemon for system tests: the real driver over the real shared memory, fed by a counter.
// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <iostream>
#include <string>

#include "daemon/core/clock.h"
#include "daemon/core/driver.h"
#include "daemon/stages/map_changes.h"
#include "ipc/shm.h"
#include "tests/support/count_allocations.h"

using namespace vdisp;

namespace {

volatile std::sig_atomic_t stop = 0;
bool blind = false, occupancy = false;

struct Camera final : ImageSource {
  std::vector<ImageSpec> open() override { return {{Pixel::gray8, 0, 640, 480}}; }
  Outcome grab(std::span<Image* const> out) noexcept override {
    out[0]->timestamp_ns = monotonic_ns();
    out[0]->flags = flag_synthetic;
    for (int y = 0; y < 480; ++y) std::memset(out[0]->row<uint8_t>(y), static_cast<int>(out[0]->sequence & 255), 640);
    if (!blind) return Outcome::valid;
    out[0]->reason = Reason::no_frame;
    return Outcome::invalid;
  }
};

/// One obstacle that comes nearer, row by row; every cell else is free.
struct Map final : ImageFilter {
  ImageSpec accept(const ImageSpec&) override { return {Pixel::count16, 0, 51, 50}; }
  bool filter(const Image& in, Image& out) noexcept override {
    for (int y = 0; y < 50; ++y) std::memset(out.row<int16_t>(y), 0, 102);
    out.row<int16_t>(static_cast<int>(in.sequence % 50))[30] = 100;
    out.grid = {0.1f, 50, 25.5f, -0.4f, 0.4f, 3, 0, 0, 0, 0};
    return true;
  }
};

/// A wall 15 cells wide, 2.5 m ahead, that goes to and fro, a row of cells that were not seen beside the rover, free ground.
struct Occupancy final : ImageFilter {
  ImageSpec accept(const ImageSpec&) override { return {Pixel::int8, 0, 51, 50}; }
  bool filter(const Image& in, Image& out) noexcept override {
    for (int y = 0; y < 50; ++y) std::memset(out.row<int8_t>(y), y < 45 ? 0 : -1, 51);
    const int phase = static_cast<int>(in.sequence / 2 % 72);
    for (int y = 24; y < 26; ++y) std::memset(out.row<int8_t>(y) + (phase < 36 ? phase : 72 - phase), 100, 15);
    out.grid = {0.1f, 50, 25.5f, -0.4f, 0.4f, 3, 0, 0, 0, 0};
    return true;
  }
};

/// Counts its frames by looking at what it made of the last one.
struct Floor final : ImageProcessor {
  std::vector<ImageSpec> check(std::span<const ImageSpec>) override { return {record_spec<FloorModel>()}; }
  Outcome process(std::span<const Image* const> in, std::span<Image* const> out) noexcept override {
    const FloorModel* last = in[1]->valid() ? record_of<FloorModel>(*in[1]) : nullptr;
    FloorModel& model = make_record<FloorModel>(*out[0]);
    model.state = FloorState::found;
    model.points = last ? last->points + 1 : 0;
    return Outcome::valid;
  }
};

/// Copies, only while somebody watches.
struct Copy final : ImageFilter {
  ImageSpec accept(const ImageSpec& in) override { return in; }
  bool filter(const Image& in, Image& out) noexcept override {
    std::memcpy(out.row<uint8_t>(0), in.row<uint8_t>(0), in.spec.bytes() - sizeof(Image));
    return true;
  }
};

int run(double rate, long frames, const ShmOptions& options) {
  Driver driver(static_cast<uint64_t>(std::time(nullptr)) << 20 | static_cast<uint64_t>(getpid()));
  const Handle left = driver.add("left", std::make_unique<Camera>(), {}, Need::always);
  driver.add("copy", std::make_unique<Copy>(), {left});
  driver.add("floor_model", std::make_unique<Floor>(), {left, driver.last("floor_model", record_spec<FloorModel>())}, Need::always);
  driver.add("map", std::make_unique<Map>(), {left}, Need::always);
  if (occupancy)
    driver.add("map_changes", std::make_unique<MapComparison>(), {driver.add("occupancy", std::make_unique<Occupancy>(), {left})},
               Need::always);
  TopicList topics;
  for (const Topic& topic : driver.published_topics()) topics.emplace_back(topic.name, topic.spec);
  SharedMemory memory(options, topics);
  driver.connect([&](const std::string& topic, const ImageSpec& spec) { return memory.outlet(topic, spec); });
  std::printf("ready %lld pid %d\n", static_cast<long long>(monotonic_ns()), getpid());
  std::fflush(stdout);
  int64_t next = monotonic_ns();
  uint64_t allocations = 0;
  for (long frame = 0; frame != frames && !stop; ++frame) {
    const int64_t begin = monotonic_ns();
    const uint64_t before = allocations_of_this_thread();
    driver.step();
    driver.beat();
    allocations += allocations_of_this_thread() - before;
    const auto period = static_cast<int64_t>(1e9 / rate);
    next = (begin > next + period ? begin : next) + period;  // as a camera: what is late is not caught up in a burst
    for (int64_t now = monotonic_ns(); now < next && !stop; now = monotonic_ns()) {
      const int64_t nap = std::min<int64_t>(next - now, 100'000'000);
      const timespec time{0, nap};
      nanosleep(&time, nullptr);
      driver.beat();
    }
  }
  std::printf("steps %llu drops %llu allocations %llu\n", static_cast<unsigned long long>(driver.steps()),
              static_cast<unsigned long long>(driver.drops()), static_cast<unsigned long long>(allocations));
  SharedMemory::leave(0);
}

}  // namespace

int main(int argc, char** argv) {
  double rate = 30;
  long frames = -1;
  ShmOptions options{"IPLObstacleDetection", "", 256};
  for (int i = 1; i < argc; ++i) {
    const std::string option = argv[i];
    const char* value = i + 1 < argc ? argv[i + 1] : "";
    if (option == "--blind" || option == "--occupancy") {
      (option == "--blind" ? blind : occupancy) = true;
      continue;
    }
    ++i;
    if (option == "--rate") rate = std::atof(value);
    if (option == "--frames") frames = std::atol(value);
    if (option == "--group") options.group = value;
    if (option == "--memory") options.memory_mib = static_cast<uint32_t>(std::atoi(value));
    if (option == "--name") options.instance = value;
  }
  std::signal(SIGTERM, [](int) { stop = 1; });
  try {
    return run(rate, frames, options);
  } catch (const ShmError& error) {
    std::cerr << error.what() << '\n';
    SharedMemory::leave(error.exit_code);
  }
}
