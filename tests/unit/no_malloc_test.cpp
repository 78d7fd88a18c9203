// no_malloc_test.cpp: after start-up the loop takes nothing from the heap.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>

#include "daemon/core/clock.h"
#include "daemon/log/edges.h"
#include "daemon/log/log.h"
#include "daemon/stages/features.h"
#include "daemon/tree.h"
#include "daemon/upkeep.h"
#include "tests/support/own_allocations.h"
#include "tests/support/temporary_folder.h"

namespace vdisp {
namespace {

/// Speaks as a rover does, and as an operator, without the client library.
class Talker {
 public:
  explicit Talker(const std::string& path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    socket_ = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK, 0);
    EXPECT_EQ(connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  }
  ~Talker() { close(socket_); }
  void say(int step) {
    OdometryMessage odometry{{command_magic, command_version, CommandType::odometry, sizeof odometry, 0},
                             monotonic_ns(),
                             0,
                             0,
                             0,
                             NAN,
                             NAN,
                             NAN,
                             NAN,
                             NAN,
                             NAN,
                             NAN};
    if (step % 10 == 9) odometry.x = NAN;
    send(socket_, &odometry, sizeof odometry, 0);
    ParameterMessage set{{command_magic, command_version, CommandType::set, sizeof set, 1}, "Map.minCount", "4", 0, 0};
    if (step % 2) std::strcpy(set.value, step % 3 ? "no number" : "5");
    send(socket_, &set, sizeof set, 0);
    while (recv(socket_, &reply_, sizeof reply_, 0) == sizeof reply_) ++replies_;
  }
  int replies() const { return replies_; }

 private:
  int socket_ = -1, replies_ = 0;
  ReplyMessage reply_;
};

/// Hears what systemd would.
class NotifySocket {
 public:
  explicit NotifySocket(const std::string& path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    socket_ = socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0);
    EXPECT_EQ(bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    setenv("NOTIFY_SOCKET", path.c_str(), 1);
    setenv("WATCHDOG_USEC", "1000000", 1);
  }
  ~NotifySocket() {
    unsetenv("NOTIFY_SOCKET");
    unsetenv("WATCHDOG_USEC");
    close(socket_);
  }
  /// Often enough, or the daemon's thread waits. Takes nothing from the heap.
  void hear() {
    char text[1024];
    for (ssize_t size; (size = recv(socket_, text, sizeof text - 1, 0)) > 0;) {
      text[size] = 0;
      ready = ready || std::strstr(text, "READY=1");
      fed = fed || std::strstr(text, "WATCHDOG=1");
      status = status || std::strstr(text, "STATUS=");
    }
  }
  bool ready = false, fed = false, status = false;

 private:
  int socket_ = -1;
};

std::string content(const std::filesystem::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

/// A model for this configuration's front end, whatever its weights say.
void make_model(Config& config, const std::string& path) {
  config.main.detectors = "vdisparity, snow";
  config.census.scale = 1;
  config.snow.model = path;
  const std::vector<float> weights(snow::vector_length, 1.0f);
  snow::ModelParts parts;
  parts.settings = front_end(config, {Pixel::gray8, 0, 320, 240});
  parts.free = parts.obstacles = parts.left = parts.right = weights;
  snow::write_model(path, parts);
}

struct NoMallocTest : testing::TestWithParam<const char*> {};

TEST_P(NoMallocTest, the_loop_takes_nothing_from_the_heap_with_every_stage_and_all_that_is_done_beside_them) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "the sanitizer has its own malloc";
#endif
  Config config;
  config.image_source.source = "sim";
  const bool both = std::string_view(GetParam()) == "snow";
  config.image_source.matcher = both ? "bm" : GetParam();
  if (config.image_source.matcher == "census") config.image_source.smooth = "median";
  config.sim.rate = 0;
  config.sim.width = 320;
  config.sim.height = 240;
  const TemporaryFolder folder;
  config.control.socket = (folder / "control").string();
  if (both) make_model(config, (folder / "model").string());
  config.recorder.seconds = 1;
  config.recorder.free = 0;
  config.recorder.folder = (folder / "flight").string();
  config.main.metrics = (folder / "vdisp.prom").string();
  NotifySocket systemd((folder / "notify").string());
  log::start(0);
  log::Edges edges(config, [] { return std::string_view(); });
  Inputs inputs(config);
  Machine machine(2);
  Driver driver(1);
  auto source = open_source(config);
  StereoSource& frames = *source;
  build_tree(driver, std::move(source), machine, config, inputs);
  Upkeep upkeep(driver, config, frames, inputs);
  driver.connect([](const std::string&, const ImageSpec& spec) { return std::make_unique<BufferOutlet>(spec); });
  driver.need_all();
  upkeep.begin({}, (folder / "drive").string(), 1, true, [] { return true; });
  uint64_t generation = 0;
  driver.set_viewer([&](const Topic& topic, const Image& image) {
    generation = image.config_generation;
    edges.see(topic, image);
    upkeep.see(topic, image);
  });
  Talker talker(config.control.socket);
  const auto step = [&](bool flight_asked) {
    upkeep.serve(flight_asked);
    const Outcome outcome = driver.step();
    driver.beat();
    upkeep.stepped(outcome);
    return outcome;
  };
  for (int i = 0; i < 5; ++i) ASSERT_EQ(step(false), Outcome::valid);
  const int64_t end_ns = monotonic_ns() + 2'500'000'000;  // health is told once a second
  CountAllocations count;
  for (int i = 0; i < 100 || monotonic_ns() < end_ns; ++i) {
    if (i < 100) talker.say(i);
    step(i == 50);
    systemd.hear();
  }
  const Allocations found = count.end();
  upkeep.stopping();
  upkeep.finish();
  log::stop();
  EXPECT_EQ(inputs.odometry_tally().accepted, 90u);
  EXPECT_EQ(inputs.odometry_tally().refused, 10u);
  EXPECT_GT(talker.replies(), 50);
  EXPECT_GT(generation, 10u);
  const std::string metrics = content(folder / "vdisp.prom");
  EXPECT_EQ(metrics.find("vdisp_frames_total 0\n"), metrics.npos) << metrics.substr(0, 500);
  EXPECT_NE(metrics.find("vdisp_frames_total "), metrics.npos);
  EXPECT_TRUE(systemd.ready && systemd.fed && systemd.status) << systemd.ready << systemd.fed << systemd.status;
  EXPECT_FALSE(std::filesystem::is_empty(folder / "drive/left"));
  EXPECT_FALSE(std::filesystem::is_empty(folder / "flight"));
  EXPECT_EQ(found.own, 0u) << "the first one:\n" << found.first;
  if (!std::string_view(GetParam()).starts_with("opencv")) {
    EXPECT_EQ(found.opencv, 0u) << "with our own matcher nothing at all allocates";
  } else {
    EXPECT_GT(found.opencv, 0u) << "the count does not work: OpenCV's matchers are known to allocate";
  }
  RecordProperty("opencv_allocations", static_cast<int>(found.opencv));
}

INSTANTIATE_TEST_SUITE_P(Matchers, NoMallocTest, testing::Values("bm", "census", "snow", "opencv", "opencv-sgbm"), [](const auto& test) {
  return std::string(test.param) == "opencv-sgbm" ? std::string("opencv_sgbm") : std::string(test.param);
});

}  // namespace
}  // namespace vdisp
