// show.cpp: the word `show`: what a calibration file says, for people and as JSON.
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "daemon/geometry/calibration_write.h"
#include "daemon/tools/calibrate/files_out.h"
#include "daemon/tools/calibrate/rotation.h"
#include "daemon/tools/calibrate/words.h"

namespace vdisp::calibrate {
namespace {

constexpr double degrees = 180 / std::numbers::pi;
constexpr const char* sides[] = {"left", "right"};

nlohmann::json to_json(const Calibration& c) {
  nlohmann::json out{
      {"format", c.format},
      {"rectified", !c.raw},
      {"hash", c.hash},
      {"view", {{"f", c.view.f}, {"cx", c.view.cx}, {"cy", c.view.cy}, {"baseline_m", c.view.baseline}, {"cx_offset", c.view.cx_offset}}}};
  if (c.width) out["width"] = c.width, out["height"] = c.height;
  if (!c.raw) return out;
  const Stand stand = stand_of(c);
  out["rotation"] = stand.rotation;
  out["translation_m"] = stand.translation;
  for (int i : {0, 1}) {
    const RawCamera& camera = (*c.raw)[i];
    out[sides[i]] = {
        {"k", camera.k}, {"distortion", camera.distortion}, {"rectification", camera.rectification}, {"projection", camera.projection}};
  }
  return out;
}

void print(const Calibration& c) {
  const StereoView& view = c.view;
  std::printf("format      %s%s\n", c.format.c_str(), c.raw ? "" : ", of images that are rectified");
  if (c.width)
    std::printf("images      %d x %d px\n", c.width, c.height);
  else
    std::printf("images      of a size that the file does not tell\n");
  std::printf("rectified   f %.3f px, centre %.3f, %.3f", view.f, view.cx, view.cy);
  std::printf(view.cx_offset != 0 ? ", right one %.3f px to the left\n" : "\n", view.cx_offset);
  std::printf("baseline    %.3f mm\n", 1000 * view.baseline);
  if (c.width)
    std::printf("view        %.1f x %.1f deg\n", 2 * degrees * std::atan(c.width / 2.0 / view.f),
                2 * degrees * std::atan(c.height / 2.0 / view.f));
  for (double z : {1.0, 2.0, 3.0, 5.0})
    std::printf("at %.0f m      %.2f px, 1/16 px is %.1f mm\n", z, view.disparity(z) - view.cx_offset,
                1000 * z * z / (16 * view.f * view.baseline));
  if (!c.raw) return;
  for (int i : {0, 1}) {
    const RawCamera& camera = (*c.raw)[i];
    std::printf("%-11s fx %.3f, fy %.3f, centre %.3f, %.3f px\n            distortion", sides[i], camera.k[0], camera.k[4], camera.k[2],
                camera.k[5]);
    for (double d : camera.distortion) std::printf(" %.6g", d);
    std::printf(" (k1 k2 p1 p2 k3 k4 k5 k6)\n");
  }
  const Stand stand = stand_of(c);
  const auto turn = rotation_vector(stand.rotation);
  std::printf("right cam   turned by %.3f, %.3f, %.3f deg about x, y, z; at %.3f, %.3f, %.3f mm\n", degrees * turn[0], degrees * turn[1],
              degrees * turn[2], 1000 * stand.translation[0], 1000 * stand.translation[1], 1000 * stand.translation[2]);
}

}  // namespace

int show(const Options& options) {
  const Calibration calibration = read_input(options.input, options.reading);
  if (options.json)
    std::cout << to_json(calibration).dump(2) << '\n';
  else
    print(calibration);
  return std::fflush(stdout) == 0 ? 0 : 74;
}

}  // namespace vdisp::calibrate
