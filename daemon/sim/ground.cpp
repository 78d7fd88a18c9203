// ground.cpp: profiles, bumps and hollows as one height field, and its triangles.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sim/ground.h"

#include <algorithm>
#include <cmath>

#include "daemon/sim/chance.h"
#include "daemon/sim/simulator.h"

namespace vdisp::sim {
namespace {

/// 0 below `from`, 1 above `to`, without a kink.
double eased(double value, double from, double to) {
  const double t = std::clamp((value - from) / (to - from), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

Hollow make_hollow(Chance& chance, bool ditch) {
  Hollow h;
  h.depth = chance.between(0.3, 1);
  h.turn = chance.between(-0.25, 0.25);
  h.near = chance.between(1.2, 3);
  h.far = ditch ? h.near + chance.between(0.5, 1.5) : Hollow::beyond;
  h.left = -Hollow::beyond;
  h.right = Hollow::beyond;
  // A part of the way is what lies straight ahead and some of one side or both.
  const int part = chance.below(4);
  const double middle = h.near * std::tan(h.turn), left = middle - chance.between(0.5, 1), right = middle + chance.between(0.5, 1);
  if (part == 1 || part == 3) h.left = left;
  if (part == 2 || part == 3) h.right = right;
  return h;
}

/// Lines of a grid: fine steps within `reach` of the origin, then ever wider ones, and each of `breaks`.
std::vector<double> lines(double reach, double step, std::initializer_list<double> breaks) {
  std::vector<double> at(breaks);
  at.push_back(0);
  const int fine = step > 0 ? static_cast<int>(reach / step) : 0;
  for (int i = 1; i <= fine; ++i) at.insert(at.end(), {i * step, -i * step});
  for (double far = std::max(reach, 1.0); far < 2 * Hollow::beyond; far *= 2) at.insert(at.end(), {far, -far});
  std::erase_if(at, [](double value) { return std::abs(value) > 2 * Hollow::beyond; });
  std::sort(at.begin(), at.end());
  at.erase(std::unique(at.begin(), at.end(), [](double a, double b) { return b - a < 1e-6; }), at.end());
  return at;
}

}  // namespace

Ground::Ground(const sim_section& parameters)
    : rise_(std::tan(parameters.slope)),
      roughness_(parameters.roughness),
      drives_(parameters.scene == "drive" || is_world(parameters.scene)),
      reach_(drives_ ? 25 : 10) {
  const std::string& shape = parameters.ground;
  // Its own numbers, so that the same seed places the same obstacles on whatever ground.
  Chance chance(static_cast<uint64_t>(parameters.seed) + 0x6071d);
  meshed_ = shape != "slope" || roughness_ > 0;
  if (shape == "ramp") {
    foot_ = chance.between(1.5, 3);
  } else if (shape == "crest") {
    peaks_ = true;
    crest_ = chance.between(2, 3.5);
  } else if (shape == "kerb" || shape == "ditch") {
    hollow_ = make_hollow(chance, shape == "ditch");
  }
  if (!peaks_ && rise_ < 0) crest_ = foot_;
  for (Wave& wave : waves_) {
    const double direction = chance.between(0, 2 * M_PI), length = chance.between(0.8, 2.4);
    wave = {2 * M_PI / length * std::cos(direction), 2 * M_PI / length * std::sin(direction), chance.between(0, 2 * M_PI)};
  }
}

double Ground::profile(double z) const {
  if (z <= foot_) return 0;
  if (peaks_ && z > crest_) return rise_ * (crest_ - foot_) - std::abs(rise_) * (z - crest_);
  return rise_ * (z - foot_);
}

double Ground::bumps(double x, double z) const {
  if (roughness_ <= 0) return 0;
  double sum = 0;
  for (const Wave& wave : waves_) sum += std::sin(wave.along_x * x + wave.along_z * z + wave.phase);
  // The sum of twelve has a deviation of 2.45: bumps reach the roughness often, and are cut softly there.
  const double from_start = std::hypot(x, z);
  const double where = (drives_ ? 1 : eased(from_start, 0.3, 1)) * (1 - eased(from_start, 0.7 * reach_, reach_));
  return roughness_ * std::tanh(sum / 2.5) * where;
}

double Ground::drop(double x, double z) const {
  if (hollow_.depth <= 0) return 0;
  const double c = std::cos(hollow_.turn), s = std::sin(hollow_.turn);
  const double aside = c * x + s * z, ahead = c * z - s * x;
  const double inside = std::min({ahead - hollow_.near, hollow_.far - ahead, aside - hollow_.left, hollow_.right - aside});
  return hollow_.depth * std::clamp(inside / wall, 0.0, 1.0);
}

double Ground::height(double x, double z) const {
  // The slope before a hollow is turned as its edge is, so that both lie along the mesh.
  const double ahead = hollow_.depth > 0 ? std::cos(hollow_.turn) * z - std::sin(hollow_.turn) * x : z;
  return profile(ahead) + bumps(x, z) - drop(x, z);
}

bool Ground::whole(double x, double z, double radius) const {
  if (hollow_.depth <= 0) return true;
  const double c = std::cos(hollow_.turn), s = std::sin(hollow_.turn);
  const double aside = c * x + s * z, ahead = c * z - s * x;
  return std::min({ahead - hollow_.near, hollow_.far - ahead, aside - hollow_.left, hollow_.right - aside}) < -radius;
}

Mesh Ground::mesh() const {
  const Hollow& h = hollow_;
  const double step = roughness_ > 0 ? (drives_ ? 0.07 : 0.04) : 0;
  const std::vector<double> across = lines(reach_, step, {h.left, h.left + wall, h.right - wall, h.right});
  const std::vector<double> ahead = lines(reach_, step, {foot_, crest_, h.near, h.near + wall, h.far - wall, h.far});
  const double c = std::cos(h.turn), s = std::sin(h.turn);
  Mesh mesh;
  for (double b : ahead) {
    for (double a : across) {
      const double x = c * a - s * b, z = c * b + s * a;
      mesh.vertex(x, -height(x, z), z);
    }
  }
  const auto columns = static_cast<unsigned>(across.size());
  for (unsigned j = 0; j + 1 < ahead.size(); ++j) {
    for (unsigned i = 0; i + 1 < columns; ++i)
      mesh.quad(j * columns + i, j * columns + i + 1, (j + 1) * columns + i + 1, (j + 1) * columns + i);
  }
  return mesh;
}

}  // namespace vdisp::sim
