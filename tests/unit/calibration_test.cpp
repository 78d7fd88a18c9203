// calibration_test.cpp: calibration files of all formats read right, and wrong ones are refused with what would be right.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/geometry/calibration.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>

#include "tests/support/temporary_folder.h"

namespace vdisp {
namespace {

const std::filesystem::path data = VDISP_SHARED_DATA;
#define NEEDS(path) \
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no " << (path).string()

std::string slurp(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// What read_calibration() says of it; empty where it takes it.
std::string refusal(const std::filesystem::path& path) {
  try {
    read_calibration(path);
  } catch (const CalibrationError& e) {
    EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << "one line: " << e.what();
    return e.what();
  }
  return {};
}
#define EXPECT_REFUSED(path, word) EXPECT_NE(refusal(path).find(word), std::string::npos) << "said: " << refusal(path)

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

std::string matrix(const std::string& name, int rows, int cols, const std::string& numbers) {
  std::ostringstream out;
  out << name << ": !!opencv-matrix\n   rows: " << rows << "\n   cols: " << cols << "\n   dt: d\n   data: [ " << numbers << " ]\n";
  return out.str();
}

const std::string head = "%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\n";
const std::string p1 = matrix("P1", 3, 4, "500., 0., 320., 0., 0., 500., 240., 0., 0., 0., 1., 0.");
const std::string p2 = matrix("P2", 3, 4, "500., 0., 310., -45., 0., 500., 240., 0., 0., 0., 1., 0.");
const std::string rectified = head + p1 + p2;

const std::string raw = head + matrix("M1", 3, 3, "500., 0., 320., 0., 502., 240., 0., 0., 1.") +
                        matrix("D1", 1, 5, "-0.2, 0.05, 0., 0., 0.") + matrix("M2", 3, 3, "501., 0., 322., 0., 503., 238., 0., 0., 1.") +
                        matrix("D2", 1, 5, "-0.2, 0.05, 0., 0., 0.") + matrix("R", 3, 3, "1., 0., 0., 0., 1., 0., 0., 0., 1.") +
                        matrix("T", 3, 1, "-0.12, 0., 0.");

const std::string svs = R"(# SVS Engine v 4.0 Stereo Camera Parameter File

[image]
have_rect 1

[external]
Tx -90.0
Ty 0.0
Tz 0.0
Rx 0.0
Ry 0.0
Rz 0.0

[left camera]
pwidth 320
pheight 240
Fy 302.0
frame 9
F 300.0
Cx 160.0
Cy 120.0
kappa1 -0.1
tau1 0.001
proj
 3.0e+002 0 1.5e+002 0
 0 300 120 0
 0 0 1 0
rect
 1 0 0
 0 1 0
 0 0 1

[right camera]
pwidth 320
pheight 240
f 300.0
Cx 160.0
Cy 120.0
kappa1 -0.1
proj
 300 0 158 -27000
 0 300 120 0
 0 0 1 0
rect
 1 0 0
 0 1 0
 0 0 1

[global]
GTx 0.0
)";

class Calibrations : public ::testing::Test {
 protected:
  std::filesystem::path file(const std::string& content, const std::string& name = "c.txt") { return folder_.write(name, content); }
  TemporaryFolder folder_;
};

TEST_F(Calibrations, rectified_projections_give_f_baseline_and_difference_of_centres) {
  const Calibration c = read_calibration(file(rectified));
  EXPECT_EQ(c.width, 640);
  EXPECT_EQ(c.height, 480);
  EXPECT_DOUBLE_EQ(c.view.f, 500);
  EXPECT_DOUBLE_EQ(c.view.cx, 320);
  EXPECT_DOUBLE_EQ(c.view.cy, 240);
  EXPECT_DOUBLE_EQ(c.view.baseline, 0.09);
  EXPECT_DOUBLE_EQ(c.view.cx_offset, 10);
  EXPECT_FALSE(c.raw);
}

TEST_F(Calibrations, xml_reads_like_yaml) {
  const auto path = folder_ / "c.xml";
  cv::FileStorage out(path.string(), cv::FileStorage::WRITE);
  out << "image_width" << 640 << "image_height" << 480;
  out << "P1" << cv::Mat(cv::Matx34d(500, 0, 320, 0, 0, 500, 240, 0, 0, 0, 1, 0));
  out << "P2" << cv::Mat(cv::Matx34d(500, 0, 310, -45, 0, 500, 240, 0, 0, 0, 1, 0));
  out.release();
  EXPECT_EQ(read_calibration(path).hash, read_calibration(file(rectified)).hash);
}

TEST_F(Calibrations, raw_cameras_are_rectified_with_equal_centres) {
  const Calibration c = read_calibration(file(raw));
  ASSERT_TRUE(c.raw);
  EXPECT_NEAR(c.view.baseline, 0.12, 1e-9);
  EXPECT_DOUBLE_EQ(c.view.cx_offset, 0);
  EXPECT_DOUBLE_EQ((*c.raw)[0].k[0], 500);
  EXPECT_DOUBLE_EQ((*c.raw)[1].k[5], 238);
  EXPECT_DOUBLE_EQ((*c.raw)[0].distortion[1], 0.05);
  EXPECT_DOUBLE_EQ((*c.raw)[0].projection[0], c.view.f);
}

TEST_F(Calibrations, stereo_calib_file_with_everything_uses_its_own_rectification) {
  const std::string identity = "1., 0., 0., 0., 1., 0., 0., 0., 1.";
  const Calibration c =
      read_calibration(file(replaced(raw, "-0.12", "-0.09") + matrix("R1", 3, 3, identity) + matrix("R2", 3, 3, identity) + p1 + p2));
  ASSERT_TRUE(c.raw);
  EXPECT_DOUBLE_EQ(c.view.cx_offset, 10);
  EXPECT_DOUBLE_EQ((*c.raw)[0].rectification[0], 1);
}

TEST_F(Calibrations, hash_follows_the_numbers_not_the_text) {
  const uint64_t hash = read_calibration(file(rectified)).hash;
  EXPECT_EQ(read_calibration(file(replaced(rectified, "500.", "5.0e+02"))).hash, hash);
  EXPECT_NE(read_calibration(file(replaced(rectified, "-45.", "-45.1"))).hash, hash);
}

TEST_F(Calibrations, contradictions_in_opencv_files_are_refused) {
  EXPECT_REFUSED(file(head + p1), "P1 and P2");
  EXPECT_REFUSED(file(replaced(rectified, "-45.", "45.")), "left and right exchanged");
  EXPECT_REFUSED(file(replaced(rectified, "-45.", "0.")), "no baseline");
  EXPECT_REFUSED(file(replaced(rectified, "-45.", "-45000.")), "metres");
  EXPECT_REFUSED(file(replaced(rectified, "-45.", ".nan")), "finite");
  EXPECT_REFUSED(file(replaced(rectified, "-45.", ".Inf")), "finite");
  EXPECT_REFUSED(file(replaced(rectified, "500.", "-500.")), "more than 0");
  EXPECT_REFUSED(file(replaced(rectified, "500.", "400.")), "one f");
  EXPECT_REFUSED(file(head + p1 + replaced(replaced(p2, "500.", "510."), "500.", "510.")), "a rectified pair has one f");
  EXPECT_REFUSED(file(head + p1 + replaced(p2, "240.", "250.")), "rows agree");
  EXPECT_REFUSED(file(replaced(rectified, "640", "0")), "0x480");
  EXPECT_REFUSED(file(replaced(rectified, "640", "-640")), "image_width");
  EXPECT_REFUSED(file(replaced(rectified, "640", "640000")), "16384");
  EXPECT_REFUSED(file(replaced(rectified, "image_height: 480\n", "")), "both");
  EXPECT_REFUSED(file(head + matrix("P1", 3, 3, "1., 0., 0., 0., 1., 0., 0., 0., 1.") + p2), "P1 is 3x3, needed is 3x4");
  EXPECT_REFUSED(file(head + matrix("P1", 3, 4, "1., 0., 0.") + p2), "3 numbers");
  EXPECT_REFUSED(file(rectified + matrix("R1", 3, 3, "1., 0., 0., 0., 1., 0., 0., 0., 1.")), "R1");
}

TEST_F(Calibrations, contradictions_of_raw_cameras_are_refused) {
  EXPECT_REFUSED(file(replaced(raw, "-0.12", "0.12")), "left and right exchanged");
  EXPECT_REFUSED(file(replaced(raw, "-0.12, 0., 0.", "0., -0.12, 0.")), "one above the other");
  EXPECT_REFUSED(file(replaced(raw, "-0.12", "-120.")), "millimetres");
  EXPECT_REFUSED(file(replaced(raw, "500.", "0.")), "more than 0");
  EXPECT_REFUSED(file(replaced(raw, "320.", "3200.")), "outside the image");
  EXPECT_REFUSED(file(replaced(raw, "M2", "X2")), "right one");
  EXPECT_REFUSED(file(replaced(raw, "D1", "X1")), "distortion of the left");
  EXPECT_REFUSED(file(replaced(raw, "T:", "X:")), "R and T");
  EXPECT_REFUSED(file(replaced(raw, "R: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 1.",
                               "R: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 2.")),
                 "no rotation");
  EXPECT_REFUSED(file(replaced(replaced(raw, "image_width: 640\n", ""), "image_height: 480\n", "")), "image size");
  const std::string identity = "1., 0., 0., 0., 1., 0., 0., 0., 1.";
  EXPECT_REFUSED(file(raw + matrix("R1", 3, 3, identity) + matrix("R2", 3, 3, identity) + p1 + p2), "by the translation");
}

TEST_F(Calibrations, files_that_are_none_are_refused) {
  EXPECT_REFUSED(folder_ / "absent.yml", "No such file");
  EXPECT_REFUSED(file(""), "empty");
  EXPECT_REFUSED(folder_.path(), "cam0/sensor.yaml");
  EXPECT_REFUSED(file("hello\n"), "known format");
  EXPECT_REFUSED(file(std::string("%YAML:1.0\n\0\0", 12)), "binary");
  EXPECT_REFUSED(file(std::string(2 << 20, 'x')), "1 MiB");
  EXPECT_REFUSED(file("%YAML:1.0\n---\na: [ 1, 2\n"), "damaged");
}

TEST_F(Calibrations, a_file_cut_off_anywhere_is_refused_or_read_right) {
  for (const std::string& whole : {rectified, raw, svs}) {
    const Calibration right = read_calibration(file(whole));
    // [global] and blank space at the end of an SVS file say nothing of the cameras.
    for (size_t length = 0; length < whole.size(); length += 3) {
      try {
        EXPECT_EQ(read_calibration(file(whole.substr(0, length))).hash, right.hash) << "cut at " << length << " of " << whole.size();
      } catch (const CalibrationError&) {
      }
    }
  }
}

TEST_F(Calibrations, svs_file_is_in_millimetres_and_whole_keys) {
  const Calibration c = read_calibration(file(svs));
  EXPECT_EQ(c.format, "SVS 4.0");
  EXPECT_EQ(c.width, 320);
  EXPECT_EQ(c.height, 240);
  EXPECT_NEAR(c.view.baseline, 0.09, 1e-12);
  EXPECT_DOUBLE_EQ(c.view.f, 300);
  EXPECT_DOUBLE_EQ(c.view.cx_offset, -8);
  ASSERT_TRUE(c.raw);
  EXPECT_DOUBLE_EQ((*c.raw)[0].k[0], 300);
  EXPECT_DOUBLE_EQ((*c.raw)[0].k[4], 302);
  EXPECT_DOUBLE_EQ((*c.raw)[1].k[4], 300) << "no fy: f";
  EXPECT_DOUBLE_EQ((*c.raw)[0].distortion[0], -0.1);
  EXPECT_DOUBLE_EQ((*c.raw)[0].distortion[2], 0.001);
  EXPECT_NEAR((*c.raw)[1].projection[3], -27, 1e-12) << "px*m";
}

TEST_F(Calibrations, svs_without_rectification_is_rectified_here) {
  const Calibration c = read_calibration(file(replaced(svs, "have_rect 1", "have_rect 0")));
  ASSERT_TRUE(c.raw);
  EXPECT_NEAR(c.view.baseline, 0.09, 1e-9);
  EXPECT_DOUBLE_EQ(c.view.cx_offset, 0);
}

TEST_F(Calibrations, svs_of_rectified_images_has_no_raw_cameras) {
  EXPECT_FALSE(read_calibration(file(replaced(svs, "have_rect 1", "have_rect 1\nrectified 1"))).raw);
}

TEST_F(Calibrations, wrong_svs_files_are_refused_with_the_line) {
  EXPECT_REFUSED(file(replaced(svs, "v 4.0", "v 2.0")), ":1: version 2.0 is too old");
  EXPECT_REFUSED(file(replaced(svs, "# SVS Engine v 4.0 Stereo Camera Parameter File\n", "")), ":1: begins with");
  EXPECT_REFUSED(file(replaced(svs, "F 300.0", "F abc")), ":19: 'f' is 'abc'");
  EXPECT_REFUSED(file(replaced(svs, "F 300.0", "F 0")), ":19: f is 0");
  EXPECT_REFUSED(file(replaced(svs, "F 300.0\n", "")), "no 'f' in [left camera]");
  EXPECT_REFUSED(file(replaced(svs, " 0 300 120 0\n", " 0 300 120\n")), ":26: a row of 'proj' has 3");
  EXPECT_REFUSED(file(replaced(svs, "-27000", "27000")), "left and right exchanged");
  EXPECT_REFUSED(file(replaced(svs, "Tx -90.0", "Tx -150.0")), "by the translation");
  EXPECT_REFUSED(file(replaced(svs, "pwidth 320", "pwidth 640")), "640x240");
  EXPECT_REFUSED(file(replaced(replaced(svs, "Fy 302.0\n", ""), "F 300.0", "F 6.0")), "pixels");
  EXPECT_REFUSED(file(replaced(svs, "rect\n 1 0 0", "rect\n 3 0 0")), "no rotation");
}

TEST(CalibrationData, svs_example_has_its_baseline) {
  const auto path = data / "svs_ini/svs_v3.2_example.ini";
  NEEDS(path);
  const Calibration c = read_calibration(path);
  EXPECT_NEAR(c.view.baseline, 0.088916, 1e-6);
  EXPECT_NEAR(c.view.cx_offset, 306.527 - 323.9165, 1e-4);
  EXPECT_DOUBLE_EQ(c.view.f, 514);
  EXPECT_EQ(c.width, 640);
}

TEST_F(Calibrations, svs_rotation_vector_and_rect_mean_the_same_as_here) {
  const auto path = data / "svs_ini/svs_v3.2_example.ini";
  NEEDS(path);
  // R2 R R1' = 1: the signs of Rx..Rz and Tx, and the sense of rect, are OpenCV's.
  const Calibration c = read_calibration(file(replaced(slurp(path), "rectified 1", "rectified 0")));
  ASSERT_TRUE(c.raw);
  cv::Matx33d r;
  cv::Rodrigues(cv::Vec3d(0.000422, 0.005006, 0.002866), r);
  const cv::Matx33d r1((*c.raw)[0].rectification.data()), r2((*c.raw)[1].rectification.data());
  EXPECT_LT(cv::norm(r2 * r * r1.t() - cv::Matx33d::eye(), cv::NORM_INF), 5e-4);
}

TEST(CalibrationData, rectified_sets_have_their_baselines) {
  const struct {
    const char* name;
    double f, baseline;
  } sets[] = {{"kitti_street", 707.0912, 0.53715},
              {"kitti_lidar/000001", 721.5377, 0.53272},
              {"rover_minnie/rectified", 339.532, 0.27030},
              {"robot_indoor", 567.2, 0.092226}};
  for (const auto& set : sets) {
    NEEDS(data / set.name / "calibration.yml");
    const Calibration c = read_calibration(data / set.name / "calibration.yml");
    EXPECT_NEAR(c.view.f, set.f, 1e-3) << set.name;
    EXPECT_NEAR(c.view.baseline, set.baseline, 1e-5) << set.name;
    EXPECT_FALSE(c.raw) << set.name;
  }
}

/// Row left - row right of matched features after rectification, px. Corners lie on whole rows: hence the mean as well.
struct RowError {
  double median, mean;
};
RowError row_error(const Calibration& c, const std::filesystem::path& left, const std::filesystem::path& right) {
  const std::filesystem::path files[] = {left, right};
  std::vector<cv::KeyPoint> points[2];
  cv::Mat descriptors[2];
  for (int i : {0, 1}) {
    const RawCamera& camera = (*c.raw)[i];
    const cv::Mat image = cv::imread(files[i].string(), cv::IMREAD_GRAYSCALE);
    EXPECT_EQ(image.size(), cv::Size(c.width, c.height));
    cv::Mat map_x, map_y, view;
    cv::initUndistortRectifyMap(cv::Matx33d(camera.k.data()), cv::Mat(camera.distortion, true), cv::Matx33d(camera.rectification.data()),
                                cv::Matx34d(camera.projection.data()), image.size(), CV_32FC1, map_x, map_y);
    cv::remap(image, view, map_x, map_y, cv::INTER_LINEAR);
    cv::ORB::create(4000, 1.2f, 3)->detectAndCompute(view, {}, points[i], descriptors[i]);
  }
  std::vector<std::vector<cv::DMatch>> matches;
  cv::BFMatcher(cv::NORM_HAMMING).knnMatch(descriptors[0], descriptors[1], matches, 2);
  std::vector<double> errors;
  for (const auto& match : matches) {
    if (match.size() < 2 || match[0].distance > 0.7f * match[1].distance) continue;
    const cv::Point2f d = points[0][match[0].queryIdx].pt - points[1][match[0].trainIdx].pt;
    if (d.x > -2 && std::abs(d.y) < 20) errors.push_back(d.y);
  }
  EXPECT_GT(errors.size(), 100u);
  if (errors.empty()) return {1e9, 1e9};
  double sum = 0, near = 0;
  for (double error : errors)
    if (std::abs(error) < 5) sum += error, ++near;  // farther: wrong matches
  for (double& error : errors) error = std::abs(error);
  std::nth_element(errors.begin(), errors.begin() + errors.size() / 2, errors.end());
  return {errors[errors.size() / 2], sum / near};
}

TEST(CalibrationData, euroc_rows_agree_after_rectification) {
  const auto mav = data / "euroc/mav0";
  NEEDS(mav);
  const Calibration c = read_calibration(mav);
  EXPECT_EQ(c.format, "EuRoC");
  EXPECT_NEAR(c.view.baseline, 0.110, 0.0005);
  ASSERT_TRUE(c.raw);
  EXPECT_EQ(read_calibration(mav / "cam0/sensor.yaml").hash, c.hash);
  EXPECT_EQ(read_calibration(mav / "cam1/sensor.yaml").hash, c.hash);
  EXPECT_EQ(read_calibration(data / "euroc").hash, c.hash);
  for (const char* name : {"1403715273262142976.png", "1403715273512143104.png"}) {
    const RowError error = row_error(c, mav / "cam0/data" / name, mav / "cam1/data" / name);
    EXPECT_LT(error.median, 0.5) << name;
    EXPECT_LT(std::abs(error.mean), 0.5) << name;
    std::printf("rows differ by %.2f px (median), %.3f (mean)\n", error.median, error.mean);
  }
}

TEST_F(Calibrations, euroc_pairs_that_do_not_fit_are_refused) {
  const auto mav = data / "euroc/mav0";
  NEEDS(mav);
  const std::string left = slurp(mav / "cam0/sensor.yaml"), right = slurp(mav / "cam1/sensor.yaml");
  folder_.write("cam0/sensor.yaml", left);
  EXPECT_REFUSED(folder_ / "cam0/sensor.yaml", "cam1/sensor.yaml");
  // As EuRoC itself publishes them: without OpenCV's first line.
  folder_.write("cam0/sensor.yaml", replaced(left, "%YAML:1.0\n", ""));
  folder_.write("cam1/sensor.yaml", right);
  EXPECT_EQ(read_calibration(folder_ / "cam0/sensor.yaml").hash, read_calibration(mav).hash);
  folder_.write("cam1/sensor.yaml", replaced(right, "752", "640"));
  EXPECT_REFUSED(folder_.path(), "resolution");
  folder_.write("cam1/sensor.yaml", replaced(right, "radial-tangential", "equidistant"));
  EXPECT_REFUSED(folder_.path(), "equidistant");
  folder_.write("cam0/sensor.yaml", right);
  folder_.write("cam1/sensor.yaml", left);
  EXPECT_REFUSED(folder_.path(), "left and right exchanged");
}

TEST(CalibrationData, rover_minnie_raw_rows_agree_after_rectification) {
  const auto set = data / "rover_minnie/raw";
  NEEDS(set);
  const Calibration c = read_calibration(set / "calibration_opencv.yml");
  EXPECT_NEAR(c.view.baseline, 0.2703, 2e-4);
  ASSERT_TRUE(c.raw);
  for (const char* name : {"000000.png", "000001.png"}) {
    const RowError error = row_error(c, set / "left" / name, set / "right" / name);
    EXPECT_LT(error.median, 0.5) << name;
    EXPECT_LT(std::abs(error.mean), 0.5) << name;
    std::printf("rows differ by %.2f px (median), %.3f (mean)\n", error.median, error.mean);
  }
}

}  // namespace
}  // namespace vdisp
