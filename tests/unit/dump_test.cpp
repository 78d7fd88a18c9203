// dump_test.cpp: the dump's files hold what the images hold, equal frames give equal bytes, and a failed dump leaves nothing.
// SPDX-License-Identifier: Apache-2.0
#include "ipc/dump.h"

#include <gtest/gtest.h>
#include <png.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "ipc/outlet.h"
#include "ipc/records.h"

namespace vdisp {
namespace {

namespace fs = std::filesystem;

std::string read(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

struct Picture {
  int width = 0, height = 0, bits = 0;
  std::vector<unsigned> pixels;
};

// libpng's own reader, not our writer turned round.
Picture read_png(const fs::path& path) {
  Picture picture;
  FILE* file = fopen(path.c_str(), "rb");
  if (!file) return picture;
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_init_io(png, file);
  png_read_png(png, info, PNG_TRANSFORM_IDENTITY, nullptr);
  picture.width = static_cast<int>(png_get_image_width(png, info));
  picture.height = static_cast<int>(png_get_image_height(png, info));
  picture.bits = png_get_bit_depth(png, info);
  for (int y = 0; y < picture.height; ++y) {
    const png_bytep row = png_get_rows(png, info)[y];
    for (int x = 0; x < picture.width; ++x)
      picture.pixels.push_back(picture.bits == 16 ? static_cast<unsigned>(row[2 * x] << 8 | row[2 * x + 1]) : row[x]);
  }
  png_destroy_read_struct(&png, &info, nullptr);
  fclose(file);
  return picture;
}

class DumpTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "dump_test.XXXXXX").string();
    ASSERT_TRUE(mkdtemp(name.data()));
    root_ = name;
  }
  void TearDown() override {
    std::error_code ignored;
    fs::remove_all(root_, ignored);
  }
  fs::path root_;
};

template <class T>
void set(BufferOutlet& outlet, std::initializer_list<T> values) {
  Image& image = outlet.loan();
  auto value = values.begin();
  for (int y = 0; y < image.spec.height; ++y)
    for (int x = 0; x < image.spec.width && value != values.end(); ++x) image.row<T>(y)[x] = *value++;
}

using Pixels = std::vector<unsigned>;

TEST_F(DumpTest, disparities_and_the_reasons_of_the_others_are_two_pictures) {
  BufferOutlet disparity({Pixel::disparity16, 0, 3, 2});
  set<int16_t>(disparity, {16, 767, rejected(Rejected::low_texture), rejected(Rejected::matcher), 0, -5});
  FrameDump dump(root_ / "000000");
  dump.add("disparity", disparity.loan());
  dump.finish();
  const Picture values = read_png(root_ / "000000/disparity.png");
  EXPECT_EQ(values.bits, 16);
  EXPECT_EQ(values.width, 3);
  EXPECT_EQ(values.pixels, (Pixels{16, 767, 0, 0, 0, 0}));
  EXPECT_EQ(read_png(root_ / "000000/disparity_reason.png").pixels, (Pixels{0, 0, 1, 6, 7, 7}))
      << "not above 0 is 7: no value is told without a reason";
  const auto frame = nlohmann::json::parse(read(root_ / "000000/frame.json"));
  EXPECT_EQ(frame["rejected"]["disparity"]["low_texture"], 1);
  EXPECT_EQ(frame["rejected"]["disparity"]["matcher"], 1);
  EXPECT_EQ(frame["rejected"]["disparity"]["measured"], 2);
  EXPECT_EQ(frame["rejected"]["disparity"]["infinity"], 2);
  EXPECT_TRUE(frame["files"]["left"].is_null()) << "a name that is not known is null";
  EXPECT_TRUE(frame["files"]["right"].is_null());
}

TEST_F(DumpTest, other_pictures_keep_their_values) {
  BufferOutlet gray({Pixel::gray8, 0, 2, 1}), height({Pixel::height16, 0, 3, 1}), occupancy({Pixel::int8, 0, 3, 1});
  BufferOutlet count({Pixel::count16, 0, 2, 1});
  set<uint8_t>(gray, {7, 255});
  set<int16_t>(height, {-1, height_unknown, 1200});
  set<int8_t>(occupancy, {-1, 0, 100});
  set<int16_t>(count, {32767, 3});
  FrameDump dump(root_ / "000000");
  dump.add("camera/left", gray.loan());
  dump.add("height", height.loan());
  dump.add("occupancy", occupancy.loan());
  dump.add("vdisparity", count.loan());
  dump.finish();
  EXPECT_EQ(read_png(root_ / "000000/camera/left.png").pixels, (Pixels{7, 255}));
  EXPECT_EQ(read_png(root_ / "000000/height.png").pixels, (Pixels{32767, 0, 33968}));
  EXPECT_EQ(read_png(root_ / "000000/occupancy.png").pixels, (Pixels{255, 0, 100}));
  EXPECT_EQ(read_png(root_ / "000000/vdisparity.png").pixels, (Pixels{32767, 3}));
  EXPECT_FALSE(fs::exists(root_ / "000000/vdisparity.pgm"));
}

TEST_F(DumpTest, map_is_also_a_map_server_map_with_the_camera_at_its_origin) {
  BufferOutlet map({Pixel::count16, 0, 3, 2});
  set<int16_t>(map, {0, 2, 3, 32767, 0, 0});
  Image& image = map.loan();
  image.grid = {};
  image.grid.cell = 0.1f;
  image.grid.origin_row = 2;
  image.grid.origin_column = 1.5f;
  image.grid.min_count = 3;
  FrameDump dump(root_ / "000000");
  dump.add("map", image);
  dump.finish();
  const std::string pgm = read(root_ / "000000/map.pgm");
  EXPECT_EQ(pgm, std::string("P5\n3 2\n255\n\xcd\xcd\0\0\xcd\xcd", 17));
  EXPECT_EQ(read(root_ / "000000/map.yaml"),
            "image: map.pgm\nresolution: 0.1\norigin: [-0.15, 0.0, 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n");
}

TEST_F(DumpTest, lines_are_tables_of_raw_disparity_and_row) {
  BufferOutlet line({Pixel::line16, 0, 4, 1}), none({Pixel::line16, 0, 2, 1});
  set<int16_t>(line, {line_none, 470, -12, line_none});
  set<int16_t>(none, {line_none, line_none});
  line.loan().camera.min_disparity = 2;
  FrameDump dump(root_ / "000000");
  dump.add("floor", line.loan());
  dump.add("limit", none.loan());
  dump.finish();
  EXPECT_EQ(read(root_ / "000000/floor.csv"), "column,row\n33,470\n34,-12\n");
  EXPECT_EQ(read(root_ / "000000/limit.csv"), "column,row\n");
}

TEST_F(DumpTest, floor_model_becomes_a_member_with_null_for_what_was_not_measured) {
  BufferOutlet outlet(record_spec<FloorModel>());
  Image& image = outlet.loan();
  image.sequence = 41;
  image.timestamp_ns = 1234567890123;
  auto& floor = make_record<FloorModel>(image);
  floor.state = FloorState::found;
  floor.a = 0.57;
  floor.pitch_rad = floor.roll_rad = NAN;
  floor.reason = Reason::no_calibration;
  FrameDump dump(root_ / "000041");
  dump.add("floor_model", image);
  dump.finish("l/41.png", "r/41.png");
  const auto frame = nlohmann::json::parse(read(root_ / "000041/frame.json"));
  EXPECT_EQ(frame["sequence"], 41);
  EXPECT_EQ(frame["timestamp_ns"], 1234567890123);
  EXPECT_EQ(frame["files"]["left"], "l/41.png");
  EXPECT_EQ(frame["valid"], true);
  EXPECT_EQ(frame["floor"]["state"], "found");
  EXPECT_EQ(frame["floor"]["model"], "line");
  EXPECT_EQ(frame["floor"]["a"], 0.57);
  EXPECT_TRUE(frame["floor"]["pitch_rad"].is_null());
  EXPECT_EQ(frame["floor"]["reason"], "no_calibration");
}

TEST_F(DumpTest, changes_of_the_map_become_generation_and_count) {
  BufferOutlet outlet(record_spec<MapChanges>());
  auto& changes = make_record<MapChanges>(outlet.loan());
  changes.generation = 7;
  changes.count = 2;
  FrameDump dump(root_ / "000000");
  dump.add("map_changes", outlet.loan());
  dump.finish();
  const auto frame = nlohmann::json::parse(read(root_ / "000000/frame.json"));
  EXPECT_EQ(frame["map_changes"], nlohmann::json::parse(R"({"generation": 7, "count": 2})"));
  EXPECT_FALSE(fs::exists(root_ / "000000/map_changes.png"));
}

TEST_F(DumpTest, what_the_cameras_deliver_becomes_a_member) {
  BufferOutlet outlet(record_spec<CameraStatus>());
  auto& status = make_record<CameraStatus>(outlet.loan());
  status.pairs = 12;
  status.apart_ms = -0.25;
  status.view[1].incomplete = 3;
  status.view[1].exposure_us = std::nan("");
  FrameDump dump(root_ / "000000");
  dump.add("camera/status", outlet.loan());
  dump.finish();
  const auto told = nlohmann::json::parse(read(root_ / "000000/frame.json"))["camera_status"];
  EXPECT_EQ(told["pairs"], 12);
  EXPECT_EQ(told["apart_ms"], -0.25);
  EXPECT_EQ(told["right"]["incomplete"], 3);
  EXPECT_TRUE(told["right"]["exposure_us"].is_null());
  EXPECT_FALSE(fs::exists(root_ / "000000/camera/status.png"));
}

TEST_F(DumpTest, the_frames_time_is_the_pictures_also_where_the_cameras_status_comes_first) {
  BufferOutlet status(record_spec<CameraStatus>()), gray({Pixel::gray8, 0, 2, 1});
  make_record<CameraStatus>(status.loan());
  gray.loan().timestamp_ns = 123;
  gray.loan().set_blind(Reason::no_camera);
  FrameDump dump(root_ / "000000");
  dump.add("camera/status", status.loan());
  dump.add("camera/left", gray.loan());
  dump.finish();
  const auto frame = nlohmann::json::parse(read(root_ / "000000/frame.json"));
  EXPECT_EQ(frame["timestamp_ns"], 123);
  EXPECT_EQ(frame["reason"], "no_camera");
}

TEST_F(DumpTest, truth_of_the_simulator_becomes_a_member_with_its_objects) {
  BufferOutlet outlet(record_spec<TruthScene>());
  auto& scene = make_record<TruthScene>(outlet.loan());
  scene.height_m = 0.8;
  scene.count = 1;
  scene.objects[0] = {ObjectKind::post, 1, 0.5f, 2.f, 0.25f, 0.25f, 1.f, 0.f, 0.25f, 0.f};
  scene.x_m = 3.5;
  scene.drop = {0.5f, 0.f, -1.f, 2.f, 1.f, 2.5f};
  FrameDump dump(root_ / "000000");
  dump.add("truth/scene", outlet.loan());
  dump.finish();
  const auto frame = nlohmann::json::parse(read(root_ / "000000/frame.json"));
  EXPECT_EQ(frame["truth_scene"]["height_m"], 0.8);
  EXPECT_EQ(frame["truth_scene"]["objects"][0]["kind"], "post");
  EXPECT_EQ(frame["truth_scene"]["objects"][0]["z"], 2.0);
  EXPECT_EQ(frame["truth_scene"]["objects"][0]["base"], 0.25);
  EXPECT_EQ(frame["truth_scene"]["rover"]["x_m"], 3.5);
  EXPECT_EQ(frame["truth_scene"]["drop"]["depth"], 0.5);
  EXPECT_EQ(frame["truth_scene"]["drop"]["right"][1], 2.5);
}

TEST_F(DumpTest, blind_images_leave_their_reason_and_no_picture_and_an_empty_line) {
  BufferOutlet gray({Pixel::gray8, 0, 2, 1}), model(record_spec<FloorModel>()), map({Pixel::count16, 0, 3, 2});
  BufferOutlet line({Pixel::line16, 0, 2, 1});
  set<int16_t>(line, {470, 471});
  line.loan().set_blind(Reason::few_points);
  make_record<FloorModel>(model.loan()).a = 3;
  model.loan().set_blind(Reason::few_points);
  map.loan().set_blind(Reason::few_points);
  FrameDump dump(root_ / "000000");
  dump.add("left", gray.loan());
  dump.add("floor_model", model.loan());
  dump.add("map", map.loan());
  dump.add("floor", line.loan());
  dump.finish();
  const auto frame = nlohmann::json::parse(read(root_ / "000000/frame.json"));
  EXPECT_EQ(frame["valid"], false);
  EXPECT_EQ(frame["reason"], "few_points");
  EXPECT_EQ(frame["stages"]["left"]["valid"], true);
  EXPECT_EQ(frame["stages"]["map"]["valid"], false);
  EXPECT_EQ(frame["stages"]["map"]["reason"], "few_points");
  EXPECT_EQ(frame["floor"]["state"], "lost");
  EXPECT_TRUE(frame["floor"]["a"].is_null());
  EXPECT_TRUE(fs::exists(root_ / "000000/left.png"));
  EXPECT_FALSE(fs::exists(root_ / "000000/map.png"));
  EXPECT_FALSE(fs::exists(root_ / "000000/map.pgm"));
  EXPECT_EQ(read(root_ / "000000/floor.csv"), "column,row\n") << "a line that is not there is a table without rows";
}

TEST_F(DumpTest, equal_images_give_equal_bytes_and_times_go_to_a_file_of_their_own) {
  BufferOutlet noise({Pixel::disparity16, 0, 64, 48});
  unsigned seed = 1;
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x) noise.loan().row<int16_t>(y)[x] = static_cast<int16_t>((seed = seed * 1103515245u + 12345u) >> 22);
  for (const char* run : {"a", "b"}) {
    noise.loan().epoch = noise.loan().ready_ns = run[0];  // differ from run to run
    FrameDump dump(root_ / run / "000000");
    dump.add("disparity", noise.loan());
    dump.add_timing("disparity", run[0]);
    dump.finish();
  }
  for (const char* file : {"disparity.png", "disparity_reason.png", "frame.json"}) {
    EXPECT_FALSE(read(root_ / "a/000000" / file).empty());
    EXPECT_EQ(read(root_ / "a/000000" / file), read(root_ / "b/000000" / file)) << file;
  }
  EXPECT_EQ(nlohmann::json::parse(read(root_ / "b/000000/timing.json"))["disparity"], 'b');
}

TEST_F(DumpTest, frame_has_its_name_only_when_it_is_complete) {
  BufferOutlet gray({Pixel::gray8, 0, 2, 1});
  {
    FrameDump dump(root_ / "000000");
    dump.add("left", gray.loan());
    EXPECT_FALSE(fs::exists(root_ / "000000"));
  }
  EXPECT_TRUE(fs::is_empty(root_)) << "a frame that was given up leaves nothing";
}

TEST_F(DumpTest, frame_that_exists_is_refused_and_kept) {
  fs::create_directories(root_ / "000000");
  try {
    FrameDump dump(root_ / "000000");
    FAIL() << "not refused";
  } catch (const WriteError& error) {
    EXPECT_EQ(error.exit_code, 73);
    EXPECT_NE(std::string(error.what()).find("000000 exists already"), std::string::npos);
  }
  EXPECT_TRUE(fs::exists(root_ / "000000"));
}

int code_of(const std::function<void()>& action, std::string& message) {
  try {
    action();
  } catch (const WriteError& error) {
    message = error.what();
    return error.exit_code;
  }
  return 0;
}

TEST_F(DumpTest, full_device_is_74_and_leaves_nothing) {
  fs::create_symlink("/dev/full", part_of(root_ / "x.png"));
  std::string message;
  EXPECT_EQ(code_of([&] { write_file(root_ / "x.png", std::string(100, 'x')); }, message), 74);
  EXPECT_NE(message.find("No space left on device"), std::string::npos) << message;
  EXPECT_EQ(message.find('\n'), std::string::npos);
  EXPECT_TRUE(fs::is_empty(root_));
}

TEST_F(DumpTest, disk_that_fills_within_a_frame_is_74_and_leaves_the_frames_before) {
  if (unshare(CLONE_NEWNS) != 0 || mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0 ||
      mount("none", root_.c_str(), "tmpfs", 0, "size=256k") != 0)
    GTEST_SKIP() << "needs root to mount a small disk";
  BufferOutlet noise({Pixel::gray8, 0, 320, 240});
  unsigned seed = 1;
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 320; ++x) noise.loan().row<uint8_t>(y)[x] = static_cast<uint8_t>((seed = seed * 1103515245u + 12345u) >> 22);
  std::string message;
  int whole = 0;
  const int code = code_of(
      [&] {
        for (; whole < 10; ++whole) {
          FrameDump dump(root_ / frame_name(whole));
          dump.add("left", noise.loan());
          dump.finish();
        }
      },
      message);
  EXPECT_EQ(code, 74);
  EXPECT_EQ(whole, 3);
  for (int i = 0; i < whole; ++i) EXPECT_EQ(read_png(root_ / frame_name(i) / "left.png").pixels.size(), 320u * 240u);
  EXPECT_EQ(std::distance(fs::directory_iterator(root_), {}), whole);
  umount(root_.c_str());
}

TEST_F(DumpTest, folder_that_may_not_be_written_is_73) {
  if (geteuid() == 0) {
    if (unshare(CLONE_NEWNS) != 0 || mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0 ||
        mount("none", root_.c_str(), "tmpfs", MS_RDONLY, nullptr) != 0)
      GTEST_SKIP() << "may not mount a read-only disk here";
  } else {
    fs::permissions(root_, fs::perms::owner_read | fs::perms::owner_exec);
  }
  std::string message;
  EXPECT_EQ(code_of([&] { FrameDump dump(root_ / "deep/000000"); }, message), 73);
  EXPECT_NE(message.find("cannot create"), std::string::npos) << message;
  EXPECT_EQ(message.find('\n'), std::string::npos);
  EXPECT_EQ(code_of([&] { write_file(root_ / "x.png", "x"); }, message), 73);
  if (geteuid() == 0)
    umount(root_.c_str());
  else
    fs::permissions(root_, fs::perms::owner_all);
}

TEST_F(DumpTest, folder_below_a_file_is_73) {
  std::ofstream(root_ / "file") << "x";
  std::string message;
  EXPECT_EQ(code_of([&] { FrameDump dump(root_ / "file/000000"); }, message), 73);
}

}  // namespace
}  // namespace vdisp
