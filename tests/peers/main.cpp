// main.cpp: vdisp-peers: obstacle grids that OpenCV and PCL make of the rectified pairs of a dump, and how long they take.
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "tests/peers/ground.h"

namespace {
namespace fs = std::filesystem;
using namespace peers;

struct Options {
  std::vector<std::string> frames;
  std::vector<std::string> matchers{"StereoBM", "StereoSGBM"}, grounds{"plane", "morphological"};
  Search search;
  int repeat = 1;
  Mounting mounting;
  Area area;
  Filters filters;
};

double elapsed_ms(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<long>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

Camera read_camera(const fs::path& frame) {
  std::ifstream file(frame / "frame.json");
  if (!file) throw std::runtime_error((frame / "frame.json").string() + ": cannot be read; name a frame's folder of a dump");
  const auto json = nlohmann::json::parse(file).at("stages").at("disparity").at("camera");
  return {json.at("f"), json.at("cx"), json.at("cy"), json.at("baseline"), json.at("cx_offset")};
}

cv::Mat read_grey(const fs::path& name) {
  auto image = cv::imread(name.string(), cv::IMREAD_GRAYSCALE);
  if (image.empty()) throw std::runtime_error(name.string() + ": no image; name a frame's folder of a dump");
  return image;
}

/// 255 where enough points lie in a cell; rows and columns as in our map: row 0 farthest, the camera below the last row.
cv::Mat grid_of(const Cloud& obstacles, const Area& area, int least) {
  cv::Mat counts = cv::Mat::zeros(cvRound(area.range / area.cell), cvRound(area.width / area.cell), CV_32S);
  for (const auto& point : obstacles) {
    const int row = counts.rows - 1 - static_cast<int>(std::floor(point.x / area.cell));
    const int column = static_cast<int>(std::floor(-point.y / area.cell + static_cast<float>(counts.cols) / 2));
    if (row >= 0 && row < counts.rows && column >= 0 && column < counts.cols) ++counts.at<int>(row, column);
  }
  return counts >= least;
}

nlohmann::json measure(const Options& options, const fs::path& frame, const std::string& matcher, const std::string& ground) {
  const cv::Mat left = read_grey(frame / "left.png"), right = read_grey(frame / "right.png");
  const Camera camera = read_camera(frame);
  std::vector<double> matching, rest;
  cv::Mat grid;
  size_t points = 0;
  // The first round is not timed where there are more: it finds cold caches.
  for (int i = 0; i < options.repeat; ++i) {
    auto start = std::chrono::steady_clock::now();
    const cv::Mat disparity = match(matcher, options.search, left, right);
    const double match_ms = elapsed_ms(start);
    start = std::chrono::steady_clock::now();
    const auto cloud = thin(point_cloud(disparity, camera, options.mounting, options.area), options.area, options.filters);
    const auto obstacles =
        ground == "plane" ? above_plane(cloud, options.area, options.filters) : not_ground(cloud, options.area, options.filters);
    grid = grid_of(*obstacles, options.area, options.filters.cell_voxels);
    if (i > 0 || options.repeat == 1) {
      matching.push_back(match_ms);
      rest.push_back(elapsed_ms(start));
    }
    points = cloud->size();
  }
  const std::string name = "peer_" + matcher + "_" + ground + ".png";
  if (!cv::imwrite((frame / name).string(), grid)) throw std::runtime_error((frame / name).string() + ": cannot be written");
  return {{"frame", frame.string()},   {"matcher", matcher}, {"ground", ground}, {"match_ms", median(matching)},
          {"ground_ms", median(rest)}, {"voxels", points},   {"file", name}};
}

void declare(CLI::App& app, Options& options) {
  app.add_option("FRAME", options.frames, "folders of frames of a dump; the grids are written there")->required();
  app.add_option("--matcher", options.matchers)->check(CLI::IsMember({"StereoBM", "StereoSGBM"}))->capture_default_str();
  app.add_option("--ground", options.grounds)->check(CLI::IsMember({"plane", "morphological"}))->capture_default_str();
  app.add_option("--ndisp", options.search.disparities, "disparities searched")->capture_default_str();
  app.add_option("--speckle", options.search.speckle, "largest area refused as a speckle [pixel]")->capture_default_str();
  app.add_option("--repeat", options.repeat, "rounds; times are medians, without the first")->check(CLI::PositiveNumber);
  app.add_option("--height", options.mounting.height, "of the camera [m]")->capture_default_str();
  app.add_option("--pitch", options.mounting.pitch, "positive looking down [rad]")->capture_default_str();
  app.add_option("--range", options.area.range, "of the grid [m]")->capture_default_str();
  app.add_option("--width", options.area.width, "of the grid [m]")->capture_default_str();
  app.add_option("--cell", options.area.cell, "of the grid [m]")->capture_default_str();
  app.add_option("--least", options.area.least, "lowest obstacle [m]")->capture_default_str();
  app.add_option("--most", options.area.most, "what is higher is not in the way [m]")->capture_default_str();
  auto& filters = options.filters;
  app.add_option("--leaf", filters.leaf, "voxel [cell]")->capture_default_str();
  app.add_option("--voxel-points", filters.voxel_points, "fewest points of a voxel")->capture_default_str();
  app.add_option("--cell-voxels", filters.cell_voxels, "fewest voxels of an obstacle's cell")->capture_default_str();
  app.add_option("--band", filters.band, "plane: how far from the mounting's ground it is sought [least]")->capture_default_str();
  app.add_option("--reach", filters.reach, "plane: distance of its points [least]")->capture_default_str();
  app.add_option("--normal-weight", filters.normal_weight, "plane: weight of normals, 0 to 1")->capture_default_str();
  app.add_option("--neighbours", filters.neighbours, "plane: points that make a normal")->capture_default_str();
  app.add_option("--tilt", filters.tilt, "plane: most against the mounting's [rad]")->capture_default_str();
  app.add_option("--window", filters.window, "morphological: largest window [cell]")->capture_default_str();
  app.add_option("--slope", filters.slope, "morphological: steepest ground")->capture_default_str();
  app.add_option("--step", filters.step, "morphological: most over the opened surface [least]")->capture_default_str();
}
}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Obstacle grids by OpenCV and PCL of the rectified pairs in frames' folders of a dump; one JSON line each.", "vdisp-peers"};
  Options options;
  declare(app, options);
  CLI11_PARSE(app, argc, argv);
  cv::setNumThreads(1);
  try {
    for (const auto& frame : options.frames)
      for (const auto& matcher : options.matchers)
        for (const auto& ground : options.grounds) std::cout << measure(options, frame, matcher, ground) << std::endl;
  } catch (const std::exception& error) {
    std::cerr << "vdisp-peers: " << error.what() << "\n";
    return 66;
  }
  return 0;
}
