// calibration_formats_test.cpp: ROS pairs and KITTI text are read, and what is written in any format reads back to the same numbers.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <charconv>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <random>
#include <sstream>
#include <tuple>

#include "daemon/geometry/calibration_write.h"
#include "tests/support/temporary_folder.h"

namespace vdisp {
namespace {

const std::filesystem::path data = VDISP_SHARED_DATA;

const char* ending_of(CalibrationFormat format) { return format == CalibrationFormat::svs ? "c.ini" : "c.yml"; }

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

/// Numbers of the calibration, in one order, so that two can be compared.
std::vector<double> numbers(const Calibration& c) {
  std::vector<double> all{
      static_cast<double>(c.width), static_cast<double>(c.height), c.view.f, c.view.cx, c.view.cy, c.view.baseline, c.view.cx_offset};
  if (!c.raw) return all;
  for (const RawCamera& camera : *c.raw) {
    all.insert(all.end(), camera.k.begin(), camera.k.end());
    all.insert(all.end(), camera.distortion.begin(), camera.distortion.end());
    all.insert(all.end(), camera.rectification.begin(), camera.rectification.end());
    all.insert(all.end(), camera.projection.begin(), camera.projection.end());
  }
  return all;
}

void expect_same(const Calibration& a, const Calibration& b, const std::string& what) {
  const auto left = numbers(a), right = numbers(b);
  ASSERT_EQ(left.size(), right.size()) << what;
  for (size_t i = 0; i < left.size(); ++i) EXPECT_NEAR(left[i], right[i], 1e-9 * std::max(1.0, std::abs(left[i]))) << what << ' ' << i;
}

class Formats : public ::testing::Test {
 protected:
  Calibration there_and_back(const Calibration& c, CalibrationFormat format) {
    const TemporaryFolder folder;
    std::filesystem::path path = folder.path();
    for (const CalibrationFile& text : calibration_texts(c, format)) {
      const auto file = folder.write(text.name.empty() ? ending_of(format) : text.name, text.content);
      if (text.name.empty()) path = file;
    }
    return read_calibration(path);
  }
  /// From each format to each other and back.
  void expect_lossless(const Calibration& c, const std::string& what) {
    constexpr CalibrationFormat all[] = {CalibrationFormat::opencv, CalibrationFormat::svs, CalibrationFormat::ros};
    for (CalibrationFormat first : all)
      for (CalibrationFormat second : all) expect_same(c, there_and_back(there_and_back(c, first), second), what);
  }
  std::string refusal(const std::filesystem::path& path, const ReadingOptions& options = {}) {
    try {
      read_calibration(path, options);
    } catch (const CalibrationError& e) {
      EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << e.what();
      return e.what();
    }
    return "";
  }
  TemporaryFolder folder_;
};
#define EXPECT_REFUSED(path, word) EXPECT_NE(refusal(path).find(word), std::string::npos) << "said: " << refusal(path)

/// Cameras that differ in everything, drawn from a seed.
Calibration random_calibration(unsigned seed) {
  std::minstd_rand random(seed + 1);
  const auto draw = [&random](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  std::array<RawCamera, 2> cameras;
  for (RawCamera& camera : cameras) {
    camera.k = {draw(480, 520), 0, draw(310, 330), 0, draw(480, 520), draw(230, 250), 0, 0, 1};
    camera.distortion = {draw(-0.3, 0.1), draw(-0.1, 0.1), draw(-1e-3, 1e-3), draw(-1e-3, 1e-3), draw(-0.02, 0.02), 0, 0, 0};
  }
  Stand stand;
  cv::Matx33d rotation;
  cv::Rodrigues(cv::Vec3d(draw(-0.03, 0.03), draw(-0.03, 0.03), draw(-0.03, 0.03)), rotation);
  std::copy_n(rotation.val, 9, stand.rotation.begin());
  stand.translation = {draw(-0.3, -0.05), draw(-0.004, 0.004), draw(-0.004, 0.004)};
  return make_calibration(640, 480, cameras, stand);
}

TEST_F(Formats, opencv_yaml_reads_back_to_the_last_bit_so_that_a_replay_sees_the_same_calibration) {
  std::mt19937_64 random(1);
  const auto any = [&](double from, double to) { return std::uniform_real_distribution(from, to)(random); };
  for (int i = 0; i < 300; ++i) {
    const double f = any(150, 1500), cx = any(300, 340), cy = any(220, 260);
    const auto number = [](double value) {
      char digits[40];
      return std::string(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
    };
    std::string text = "%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\n";
    for (const auto& [name, x, t] : {std::tuple{"P1", cx, 0.0}, std::tuple{"P2", cx - any(-3, 3), -any(20, 400)}})
      text += std::string(name) + ": !!opencv-matrix\n   rows: 3\n   cols: 4\n   dt: d\n   data: [ " + number(f) + ", 0., " + number(x) +
              ", " + number(t) + ", 0., " + number(f) + ", " + number(cy) + ", 0., 0., 0., 1., 0. ]\n";
    const Calibration c = read_calibration(folder_.write("p.yml", text));
    EXPECT_EQ(there_and_back(c, CalibrationFormat::opencv).hash, c.hash) << text;
  }
}

TEST_F(Formats, random_cameras_go_through_every_pair_of_formats_unchanged) {
  for (unsigned seed = 0; seed < 20; ++seed) expect_lossless(random_calibration(seed), "seed " + std::to_string(seed));
}

TEST_F(Formats, rectified_pairs_stay_rectified) {
  Calibration c;
  c.width = 640, c.height = 400;
  c.view = {339.532, 318.834, 205.771, 0.2703, 4.25};
  expect_lossless(c, "rectified");
  EXPECT_FALSE(there_and_back(c, CalibrationFormat::ros).raw);
  EXPECT_FALSE(there_and_back(c, CalibrationFormat::svs).raw);
}

TEST_F(Formats, rational_lenses_are_kept_by_opencv_and_ros_and_refused_by_svs) {
  Calibration c = random_calibration(3);
  (*c.raw)[0].distortion[5] = 0.01;
  expect_same(c, there_and_back(c, CalibrationFormat::ros), "ros");
  expect_same(c, there_and_back(c, CalibrationFormat::opencv), "opencv");
  EXPECT_THROW(calibration_texts(c, CalibrationFormat::svs), CalibrationError);
}

TEST_F(Formats, the_stand_of_the_right_camera_is_what_it_was_made_of) {
  std::array<RawCamera, 2> cameras;
  for (RawCamera& camera : cameras) camera.k = {500, 0, 320, 0, 500, 240, 0, 0, 1};
  Stand made;
  cv::Matx33d rotation;
  cv::Rodrigues(cv::Vec3d(0.01, -0.02, 0.03), rotation);
  std::copy_n(rotation.val, 9, made.rotation.begin());
  made.translation = {-0.12, 0.002, 0.003};
  const Stand found = stand_of(make_calibration(640, 480, cameras, made));
  for (int i = 0; i < 9; ++i) EXPECT_NEAR(found.rotation[i], made.rotation[i], 1e-12);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(found.translation[i], made.translation[i], 1e-12);
}

TEST_F(Formats, real_files_go_through_every_pair_of_formats_unchanged) {
  const std::filesystem::path files[] = {data / "rover_minnie/raw/calibration_opencv.yml",
                                         data / "svs_ini/svs_v3.2_example.ini",
                                         data / "euroc/mav0",
                                         data / "robot_indoor/calibration.yml",
                                         data / "kitti_street/calibration.yml",
                                         data / "kitti_lidar/000003/calibration.yml"};
  for (const auto& file : files) {
    if (!std::filesystem::exists(file)) GTEST_SKIP() << "no " << file;
    expect_lossless(read_calibration(file), file.string());
  }
  ReadingOptions raw;
  raw.unrectified = true;
  expect_lossless(read_calibration(data / "svs_ini/svs_v3.2_example.ini", raw), "SVS, unrectified");
}

const std::string ros_left = R"(image_width: 640
image_height: 480
camera_name: narrow_stereo/left
camera_matrix:
  rows: 3
  cols: 3
  data: [500.0, 0, 320.5, 0, 501.0, 240.0, 0, 0, 1]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.2, 0.05, 0.001, -0.001, 0]
rectification_matrix:
  rows: 3
  cols: 3
  data:
  - 1.0
  - 0.0
  - 0.0
  - 0.0
  - 1.0
  - 0.0
  - 0.0
  - 0.0
  - 1.0
projection_matrix:
  rows: 3
  cols: 4
  data: [490.0, 0.0, 315.0, 0.0, 0.0, 490.0, 241.0, 0.0,
         0.0, 0.0, 1.0, 0.0]
)";
const std::string ros_right = replaced(ros_left, "315.0, 0.0, 0.0", "315.0, -49.0, 0.0");

TEST_F(Formats, a_ros_pair_is_found_from_its_folder_and_from_either_file) {
  folder_.write("left.yaml", ros_left);
  folder_.write("right.yaml", ros_right);
  const Calibration c = read_calibration(folder_.path());
  EXPECT_EQ(c.format, "ROS camera_info");
  EXPECT_DOUBLE_EQ(c.view.f, 490);
  EXPECT_DOUBLE_EQ(c.view.baseline, 0.1);
  ASSERT_TRUE(c.raw);
  EXPECT_DOUBLE_EQ((*c.raw)[0].k[2], 320.5);
  EXPECT_DOUBLE_EQ((*c.raw)[1].distortion[1], 0.05);
  EXPECT_EQ(read_calibration(folder_ / "left.yaml").hash, c.hash);
  EXPECT_EQ(read_calibration(folder_ / "right.yaml").hash, c.hash);
}

TEST_F(Formats, ros_files_that_make_no_pair_are_refused) {
  folder_.write("left.yaml", ros_left);
  EXPECT_REFUSED(folder_ / "left.yaml", "right.yaml");
  folder_.write("ost.yaml", ros_left);
  EXPECT_REFUSED(folder_ / "ost.yaml", "left and right");
  folder_.write("right.yaml", replaced(ros_right, "plumb_bob", "equidistant"));
  EXPECT_REFUSED(folder_.path(), "equidistant");
  folder_.write("right.yaml", replaced(ros_right, "640", "320"));
  EXPECT_REFUSED(folder_.path(), "size");
  folder_.write("right.yaml", replaced(ros_right, "-0.2,", ".nan,"));
  EXPECT_REFUSED(folder_.path(), "distortion_coefficients");
  folder_.write("right.yaml", replaced(ros_right, "[500.0", "[0.0"));
  EXPECT_REFUSED(folder_.path(), "not calibrated");
  folder_.write("left.yaml", ros_right);
  folder_.write("right.yaml", ros_left);
  EXPECT_REFUSED(folder_.path(), "left and right exchanged");
}

const std::string kitti =
    R"(P0: 7.210000e+02 0.000000e+00 6.100000e+02 0.000000e+00 0.000000e+00 7.210000e+02 1.730000e+02 0.000000e+00 0.000000e+00 0.000000e+00 1.000000e+00 0.000000e+00
P1: 7.210000e+02 0.000000e+00 6.100000e+02 -3.893400e+02 0.000000e+00 7.210000e+02 1.730000e+02 0.000000e+00 0.000000e+00 0.000000e+00 1.000000e+00 0.000000e+00
P2: 7.210000e+02 0.000000e+00 6.100000e+02 4.326000e+01 0.000000e+00 7.210000e+02 1.730000e+02 2.000000e-01 0.000000e+00 0.000000e+00 1.000000e+00 3.000000e-03
P3: 7.210000e+02 0.000000e+00 6.100000e+02 -3.460800e+02 0.000000e+00 7.210000e+02 1.730000e+02 2.100000e+00 0.000000e+00 0.000000e+00 1.000000e+00 3.000000e-03
R0_rect: 1.000000e+00 0.000000e+00 0.000000e+00 0.000000e+00 1.000000e+00 0.000000e+00 0.000000e+00 0.000000e+00 1.000000e+00
)";

TEST_F(Formats, kitti_tells_the_grey_pair_and_the_colour_pair) {
  const auto file = folder_.write("calib.txt", kitti);
  const Calibration grey = read_calibration(file);
  EXPECT_EQ(grey.format, "KITTI");
  EXPECT_DOUBLE_EQ(grey.view.f, 721);
  EXPECT_NEAR(grey.view.baseline, 389.34 / 721, 1e-12);
  EXPECT_FALSE(grey.raw);
  EXPECT_EQ(read_calibration(folder_.path()).hash, grey.hash);
  ReadingOptions colour;
  colour.colour = true;
  EXPECT_NEAR(read_calibration(file, colour).view.baseline, (43.26 + 346.08) / 721, 1e-12);
  Calibration sized = grey;
  sized.width = 1242, sized.height = 375;
  expect_lossless(sized, "KITTI");
}

const std::string cam_to_cam = R"(calib_time: 01-Feb-2020 10:00:00
corner_dist: 1.000000e-01
S_00: 1.392000e+03 5.120000e+02
K_00: 9.840000e+02 0.000000e+00 6.900000e+02 0.000000e+00 9.820000e+02 2.340000e+02 0.000000e+00 0.000000e+00 1.000000e+00
D_00: -3.700000e-01 2.000000e-01 2.000000e-03 1.000000e-03 -7.000000e-02
R_rect_00: 1.0 0.0 0.0 0.0 1.0 0.0 0.0 0.0 1.0
S_rect_00: 1.242000e+03 3.750000e+02
P_rect_00: 7.210000e+02 0.000000e+00 6.100000e+02 0.000000e+00 0.000000e+00 7.210000e+02 1.730000e+02 0.000000e+00 0.000000e+00 0.000000e+00 1.000000e+00 0.000000e+00
S_01: 1.392000e+03 5.120000e+02
K_01: 9.890000e+02 0.000000e+00 7.020000e+02 0.000000e+00 9.870000e+02 2.450000e+02 0.000000e+00 0.000000e+00 1.000000e+00
D_01: -3.600000e-01 1.800000e-01 1.100000e-03 -6.000000e-04 -5.300000e-02
R_rect_01: 1.0 0.0 0.0 0.0 1.0 0.0 0.0 0.0 1.0
S_rect_01: 1.242000e+03 3.750000e+02
P_rect_01: 7.210000e+02 0.000000e+00 6.100000e+02 -3.893400e+02 0.000000e+00 7.210000e+02 1.730000e+02 0.000000e+00 0.000000e+00 0.000000e+00 1.000000e+00 0.000000e+00
)";

TEST_F(Formats, kitti_cam_to_cam_is_of_rectified_images_unless_asked_otherwise) {
  const auto file = folder_.write("calib_cam_to_cam.txt", cam_to_cam);
  const Calibration rectified = read_calibration(file);
  EXPECT_FALSE(rectified.raw);
  EXPECT_EQ(rectified.width, 1242);
  ReadingOptions raw;
  raw.unrectified = true;
  const Calibration c = read_calibration(file, raw);
  ASSERT_TRUE(c.raw);
  EXPECT_EQ(c.width, 1392);
  EXPECT_DOUBLE_EQ((*c.raw)[1].distortion[4], -5.3e-02);
  EXPECT_NEAR(c.view.baseline, 0.54, 1e-9);
  expect_lossless(c, "KITTI, unrectified");
}

TEST_F(Formats, wrong_kitti_files_are_refused_with_the_line) {
  EXPECT_REFUSED(folder_.write("c.txt", replaced(kitti, "-3.893400e+02", "nan")), "c.txt:2: P1");
  EXPECT_REFUSED(folder_.write("c.txt", replaced(kitti, "-3.893400e+02 ", "")), "11 numbers");
  EXPECT_REFUSED(folder_.write("c.txt", replaced(kitti, "-3.893400e+02", "3.875744e+02")), "left and right exchanged");
  EXPECT_REFUSED(folder_.write("c.txt", kitti.substr(0, kitti.find("P2:") - 4)), "truncated");
  EXPECT_REFUSED(folder_.write("c.txt", kitti.substr(0, kitti.find("P1:"))), "no P1");
  ReadingOptions raw;
  raw.unrectified = true;
  EXPECT_NE(refusal(folder_.write("c.txt", kitti), raw).find("calib_cam_to_cam"), std::string::npos);
}

TEST_F(Formats, a_size_that_no_whole_number_holds_is_refused_in_the_files_own_number) {
  const std::string svs = calibration_texts(random_calibration(5), CalibrationFormat::svs)[0].content;
  const size_t at = svs.find("pwidth "), end = svs.find('\n', at);
  for (const char* width : {"3.2e+92", "-1e+10", "1e+06"})
    EXPECT_REFUSED(folder_.write("c.ini", std::string(svs).replace(at + 7, end - at - 7, width)), std::string("image size is ") + width);
  const std::string camera =
      "sensor_type: camera\nT_BS:\n  rows: 4\n  cols: 4\n  data: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\nresolution: [752, "
      "4e+80]\n"
      "camera_model: pinhole\nintrinsics: [458, 457, 367, 248]\ndistortion_model: radtan\n"
      "distortion_coefficients: [0, 0, 0, 0]\n";
  for (const char* name : {"cam0/sensor.yaml", "cam1/sensor.yaml"}) folder_.write(name, camera);
  EXPECT_REFUSED(folder_.path(), "image size is 752x4e+80");
}

/// Cut off anywhere, a file is refused or, where only blanks are missing, read as the whole.
TEST_F(Formats, files_cut_off_anywhere_are_refused_or_read_right) {
  const Calibration c = random_calibration(5);
  const std::string texts[] = {kitti, calibration_texts(c, CalibrationFormat::svs)[0].content};
  for (const std::string& text : texts) {
    const uint64_t whole = read_calibration(folder_.write("whole.txt", text)).hash;
    for (size_t length = 1; length < text.size(); length += 3) {
      const auto file = folder_.write("cut.txt", text.substr(0, length));
      const bool taken = refusal(file).empty();
      if (taken) {
        EXPECT_EQ(read_calibration(file).hash, whole) << length;
      }
    }
  }
}

}  // namespace
}  // namespace vdisp
