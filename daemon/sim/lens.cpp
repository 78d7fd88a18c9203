// lens.cpp: cameras with the errors of cheap ones, and their rays.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sim/lens.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace vdisp::sim {
namespace {

std::array<double, 9> rotation(double x, double y, double z) {
  const double cx = std::cos(x), sx = std::sin(x), cy = std::cos(y), sy = std::sin(y), cz = std::cos(z), sz = std::sin(z);
  return {cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx, sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx, -sy, cy * sx,
          cy * cx};
}

/// OpenCV's lens: ideal (x, y) to distorted.
void distort(const std::array<double, 8>& d, double x, double y, double& xd, double& yd) {
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (d[0] + r2 * (d[1] + r2 * d[4]));
  xd = x * radial + 2 * d[2] * x * y + d[3] * (r2 + 2 * x * x);
  yd = y * radial + d[2] * (r2 + 2 * y * y) + 2 * d[3] * x * y;
}

uint64_t hash_of(const Calibration& calibration) {
  uint64_t hash = 0xcbf29ce484222325u;
  const auto add = [&](const auto& values) {
    for (double value : values) {
      uint64_t bits;
      std::memcpy(&bits, &value, sizeof bits);
      for (int byte = 0; byte < 8; ++byte) hash = (hash ^ ((bits >> (8 * byte)) & 0xff)) * 0x100000001b3u;
    }
  };
  for (const RawCamera& camera : *calibration.raw) {
    add(camera.k);
    add(camera.distortion);
    add(camera.rectification);
    add(camera.projection);
  }
  add(std::array<double, 2>{static_cast<double>(calibration.width), static_cast<double>(calibration.height)});
  return hash;
}

template <class Look>
Rays make_rays(int width, int height, Look look) {
  Rays rays;
  rays.width = width;
  rays.height = height;
  rays.tiles_x = (width + Rays::tile_width - 1) / Rays::tile_width;
  rays.tiles_y = (height + Rays::tile_height - 1) / Rays::tile_height;
  rays.x.reserve(static_cast<size_t>(rays.tiles()) * Rays::tile_pixels);
  rays.y.reserve(rays.x.capacity());
  for (int tile = 0; tile < rays.tiles(); ++tile) {
    const int u0 = tile % rays.tiles_x * Rays::tile_width, v0 = tile / rays.tiles_x * Rays::tile_height;
    Rays::Bounds b{1e9f, -1e9f, 1e9f, -1e9f};
    double least_step = 1e9;
    for (int i = 0; i < Rays::tile_pixels; ++i) {
      double x, y;
      look(u0 + i % Rays::tile_width, v0 + i / Rays::tile_width, x, y);
      if (i == 1) least_step = std::abs(x - rays.x.back());
      rays.x.push_back(static_cast<float>(x));
      rays.y.push_back(static_cast<float>(y));
      b = {std::min(b.x0, rays.x.back()), std::max(b.x1, rays.x.back()), std::min(b.y0, rays.y.back()), std::max(b.y1, rays.y.back())};
    }
    const float margin = static_cast<float>(least_step) / 2;
    b = {b.x0 - margin, b.x1 + margin, b.y0 - margin, b.y1 + margin};
    rays.bounds.push_back(b);
    if (u0 == 0) rays.rows.push_back(b);
    Rays::Bounds& row = rays.rows.back();
    row = {std::min(row.x0, b.x0), std::max(row.x1, b.x1), std::min(row.y0, b.y0), std::max(row.y1, b.y1)};
  }
  return rays;
}

}  // namespace

Calibration make_calibration(const sim_section& parameters) {
  Calibration calibration;
  calibration.width = parameters.width;
  calibration.height = parameters.height;
  calibration.format = "simulator";
  const double f = 576.0 * parameters.width / 640.0, scale = parameters.width / 640.0, error = parameters.distortion;
  const double cx = parameters.width / 2.0, cy = parameters.height / 2.0, degree = M_PI / 180;
  calibration.view = {f, cx, cy, 0.09, 0};
  // At the greatest error the right camera is turned by half a degree about each axis, the left one by a fifth of one. k2 keeps
  // the lens one-to-one over the whole image.
  RawCamera left, right;
  left.k = {f * (1 + 0.010 * error), 0, cx + 6 * error * scale, 0, f * (1 + 0.012 * error), cy - 5 * error * scale, 0, 0, 1};
  right.k = {f * (1 - 0.008 * error), 0, cx - 8 * error * scale, 0, f * (1 - 0.006 * error), cy + 7 * error * scale, 0, 0, 1};
  left.distortion = {-error, 0.30 * error, 0.0010 * error, -0.0015 * error, 0, 0, 0, 0};
  right.distortion = {-0.97 * error, 0.29 * error, -0.0012 * error, 0.0010 * error, 0, 0, 0, 0};
  left.rectification = rotation(0.4 * error * degree, -0.3 * error * degree, -0.4 * error * degree);
  right.rectification = rotation(-1.0 * error * degree, 0.8 * error * degree, 0.9 * error * degree);
  left.projection = {f, 0, cx, 0, 0, f, cy, 0, 0, 0, 1, 0};
  right.projection = {f, 0, cx, -f * calibration.view.baseline, 0, f, cy, 0, 0, 0, 1, 0};
  calibration.raw = {left, right};
  calibration.hash = hash_of(calibration);
  return calibration;
}

void undistort(const RawCamera& camera, double u, double v, double& x, double& y) {
  const std::array<double, 8>& d = camera.distortion;
  const double xd = (u - camera.k[2]) / camera.k[0], yd = (v - camera.k[5]) / camera.k[4];
  for (int i = 0; i < 40; ++i) {
    double fx, fy;
    distort(d, x, y, fx, fy);
    const double dx = xd - fx, dy = yd - fy;
    if (dx * dx + dy * dy < 1e-22) break;
    // Newton; the Jacobian is symmetric.
    const double r2 = x * x + y * y, radial = 1 + r2 * (d[0] + r2 * (d[1] + r2 * d[4])),
                 slope = 2 * (d[0] + r2 * (2 * d[1] + 3 * r2 * d[4]));
    const double xx = radial + slope * x * x + 2 * d[2] * y + 6 * d[3] * x, yy = radial + slope * y * y + 6 * d[2] * y + 2 * d[3] * x;
    const double xy = slope * x * y + 2 * d[2] * x + 2 * d[3] * y, scale = 1 / (xx * yy - xy * xy);
    x += (dx * yy - dy * xy) * scale;
    y += (dy * xx - dx * xy) * scale;
  }
}

Rays raw_rays(const RawCamera& camera, int width, int height) {
  const std::array<double, 9>& r = camera.rectification;
  double a = 0, b = 0;
  return make_rays(width, height, [&](int u, int v, double& x, double& y) {
    if (u % Rays::tile_width == 0 && v % Rays::tile_height == 0) a = b = 0;
    undistort(camera, u, v, a, b);
    const double z = r[6] * a + r[7] * b + r[8];
    x = (r[0] * a + r[1] * b + r[2]) / z;
    y = (r[3] * a + r[4] * b + r[5]) / z;
  });
}

Rays rectified_rays(const StereoView& view, int width, int height) {
  return make_rays(width, height, [&](int u, int v, double& x, double& y) {
    x = (u - view.cx) / view.f;
    y = (v - view.cy) / view.f;
  });
}

}  // namespace vdisp::sim
