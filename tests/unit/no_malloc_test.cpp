// no_malloc_test.cpp: after start-up the loop takes nothing from the heap.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cmath>
#include <cstring>

#include "daemon/control/command_socket.h"
#include "daemon/core/clock.h"
#include "daemon/log/edges.h"
#include "daemon/log/log.h"
#include "daemon/record/flight_recorder.h"
#include "daemon/stages/features.h"
#include "daemon/tree.h"
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

TEST_P(NoMallocTest, the_loop_takes_nothing_from_the_heap_with_every_stage_on) {
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
  log::start(0);
  log::Edges edges(config, [] { return std::string_view(); });
  Inputs inputs(config);
  Machine machine(2);
  Driver driver(1);
  build_tree(driver, open_source(config), machine, config, inputs);
  driver.connect([](const std::string&, const ImageSpec& spec) { return std::make_unique<BufferOutlet>(spec); });
  driver.need_all();
  config.recorder.seconds = 1;
  config.recorder.folder = (folder / "flight").string();
  RecordingInfo info;
  info.width = info.height = 1;
  FlightRecorder recorder(config, {Pixel::gray8, 0, 320, 240}, info, {});
  driver.set_viewer([&](const Topic& topic, const Image& image) {
    edges.see(topic, image);
    recorder.see(topic.name, image);
  });
  CommandSocket control(config, {}, inputs, true, [](std::string_view line, bool) { log::warn("{}", line); });
  Talker talker(config.control.socket);
  const auto serve = [&](int step) {
    talker.say(step);
    if (control.serve(driver.steps())) driver.set_config_generation(control.generation());
  };
  for (int i = 0; i < 5; ++i) ASSERT_EQ(driver.step(), Outcome::valid);
  CountAllocations count;
  for (int i = 0; i < 100; ++i) {
    serve(i);
    driver.step();
    recorder.finish_step(monotonic_ns());
    driver.beat();
  }
  const Allocations found = count.end();
  log::stop();
  EXPECT_EQ(inputs.odometry_tally().accepted, 90u);
  EXPECT_EQ(inputs.odometry_tally().refused, 10u);
  EXPECT_GT(talker.replies(), 50);
  EXPECT_GT(control.generation(), 10u);
  EXPECT_EQ(found.own, 0u) << "the first one:\n" << found.first;
  if (!std::string_view(GetParam()).starts_with("opencv")) {
    EXPECT_EQ(found.opencv, 0u) << "with our own matcher nothing at all allocates";
  } else {
    EXPECT_GT(found.opencv, 0u) << "the count does not work: OpenCV's matchers are known to allocate";
  }
  RecordProperty("opencv_allocations_per_frame", static_cast<int>(found.opencv / 100));
}

INSTANTIATE_TEST_SUITE_P(Matchers, NoMallocTest, testing::Values("bm", "census", "snow", "opencv", "opencv-sgbm"), [](const auto& test) {
  return std::string(test.param) == "opencv-sgbm" ? std::string("opencv_sgbm") : std::string(test.param);
});

}  // namespace
}  // namespace vdisp
