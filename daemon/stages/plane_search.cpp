// plane_search.cpp: planes drawn at random, judged, and the best fitted to their points.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/plane_search.h"

#include <algorithm>
#include <cmath>

#include "daemon/kernels/line_search.h"
#include "daemon/stages/projection.h"

namespace vdisp {
namespace {

constexpr int column_step = 12, row_step = 3;       // px of 640x480, others in proportion; rows, as far ground has few
constexpr double least_on = 40, most_beyond = 0.5;  // points
constexpr double price_of_beyond = 0.25, weight_of_feet = 6;
constexpr int strips = 16, feet_of_strip = 40;  // parts of the image's width; points of each
constexpr size_t points_at_once = 1024;
constexpr size_t few = 3;  // guesses are fitted to every third point, the best of them to all
constexpr int most_fits = 15, few_fits = 2;
constexpr double as_good = 0.85;  // as before the last fits: on unlike grounds they may wander off to the one that is not at the feet
constexpr double bumps = 0.25;    // rad: pitch that driving adds
constexpr double most_roll = 0.45, most_pitch = 1.35;    // rad
constexpr double least_height = 0.05, most_height = 15;  // m
constexpr int tries_of_kind[] = {40, 60, 80};            // three, two, one points
// How far a floor may be off what was expected until that counts half of what lies on it.
constexpr double usual_pitch = 0.3, usual_pitch_off = 0.5;  // where nothing is known of it: a wall is no floor
constexpr double height_off = 0.25, pitch_off = 0.15, roll_off = 0.35, last_height_off = 0.15;

int step(int of_standard, int size, int standard) { return std::max(of_standard * size / standard, 1); }

double bell(double off, double half) { return 1 / (1 + off * off / (half * half)); }

}  // namespace

double PlaneSearch::reach(double floor_disparity) {
  return static_cast<double>(plane_reach.reach) + static_cast<double>(plane_reach.share) * floor_disparity;
}

void PlaneSearch::prepare(const ImageSpec& disparity) {
  const auto steps = [](int size, int step) { return static_cast<size_t>(size / step + 2); };
  const size_t room =
      steps(disparity.width, step(column_step, disparity.width, 640)) * steps(disparity.height, step(row_step, disparity.height, 480));
  all_.reserve(room);
  few_.reserve(room / few + 1);
  half_width_ = disparity.width / 2.0;
  half_height_ = disparity.height / 2.0;
  feet_.reserve(strips * feet_of_strip);
}

void PlaneSearch::List::reserve(size_t most) {
  for (auto* list : {&u, &v, &d}) list->assign(kernels::point_room(most), 0.0f);
}

void PlaneSearch::List::add(const List& other, size_t i) {
  u[n] = other.u[i];
  v[n] = other.v[i];
  d[n++] = other.d[i];
}

size_t PlaneSearch::collect(const Image& disparity) {
  const CameraGeometry& g = disparity.camera;
  const kernels::Search search = search_of(g, 16 * g.disparities);
  const int across = step(column_step, disparity.spec.width, 640), down = step(row_step, disparity.spec.height, 480);
  all_.n = few_.n = feet_.n = 0;
  std::array<int, strips> taken{};
  for (int v = disparity.spec.height - 1 - down / 2; v >= 0; v -= down) {
    const int16_t* row = disparity.row<int16_t>(v);
    // Rows are shifted against each other, so that no column of the image is always left out.
    for (int u = v * 5 / 3 % across; u < disparity.spec.width; u += across) {
      if (!search.counts(row[u])) continue;
      const size_t i = all_.n++;
      all_.u[i] = static_cast<float>(u) - g.cx;
      all_.v[i] = static_cast<float>(v) - g.cy;
      all_.d[i] = static_cast<float>(true_disparity(g, row[u] - search.first));
      if (i % few == 0) few_.add(all_, i);
      if (taken[static_cast<size_t>(u * strips / disparity.spec.width)]++ < feet_of_strip) feet_.add(all_, i);
    }
  }
  return all_.n;
}

bool PlaneSearch::holds(const Found& found) {
  return found.all.on >= least_on && found.feet.beyond <= most_beyond * (found.feet.on + least_on) &&
         found.all.beyond <= found.all.on + 12 * found.feet.on;
}

bool PlaneSearch::within_mounting(const PlanePose& pose) const {
  const auto& m = config_.mounting;
  const double pitch = config_.expected_pitch();
  return std::abs(pose.height / m.height - 1) <= 1.5 * m.heightTolerance &&
         (std::isnan(pitch) || std::abs(pose.pitch - pitch) <= m.pitchTolerance + bumps);
}

bool PlaneSearch::drivable(const PlanePose& pose) const {
  const auto& m = config_.mounting;
  const double steepest = config_.floor.maxSlope + m.pitchTolerance;
  const double slope = pose.pitch - config_.expected_pitch();
  const double tolerance = 1.5 * m.heightTolerance, height = pose.height / m.height;
  const HeightRange ramp = height_over_ramp(slope);
  return std::abs(slope) <= steepest && std::abs(pose.roll - m.roll) <= steepest && height >= std::min(ramp.least, 1 - tolerance) &&
         height <= std::max(ramp.most, 1 + tolerance);
}

std::optional<FloorPlane> PlaneSearch::through_three(Random& random) const {
  const auto a = point(any(random)), b = point(any(random)), c = point(any(random));
  const double bu = b[0] - a[0], bv = b[1] - a[1], bd = b[2] - a[2], cu = c[0] - a[0], cv = c[1] - a[1], cd = c[2] - a[2];
  const double area = bu * cv - bv * cu;
  if (std::abs(area) < 100) return std::nullopt;
  const double across = (bd * cv - bv * cd) / area, down = (bu * cd - bd * cu) / area;
  return FloorPlane{across, down, a[2] - across * a[0] - down * a[1]};
}

std::optional<FloorPlane> PlaneSearch::through_two(Random& random, double roll) const {
  const auto a = point(any(random)), b = point(any(random));
  const double tangent = std::tan(roll), run = (b[1] - a[1]) + tangent * (b[0] - a[0]);
  if (std::abs(run) < 10) return std::nullopt;
  const double down = (b[2] - a[2]) / run;
  return FloorPlane{tangent * down, down, a[2] - down * (a[1] + tangent * a[0])};
}

std::optional<FloorPlane> PlaneSearch::through_one(Random& random, const StereoView& view, double roll, double height) const {
  const auto a = point(any(random));
  // sin t + w cos t = q, with w the slope of the ray along the roll's down, and q what its disparity asks for.
  const double w = (a[0] * std::sin(roll) + a[1] * std::cos(roll)) / view.f, q = height * a[2] / (view.f * view.baseline);
  const double length = std::hypot(1, w);
  if (q >= length) return std::nullopt;
  return plane_of({std::asin(q / length) - std::atan(w), roll, height}, view);
}

std::optional<FloorPlane> PlaneSearch::draw(int kind, Random& random, const StereoView& view) const {
  const double chance = static_cast<double>(random() % 2001) / 1000 - 1;  // -1..1
  const double expected_roll = last_roll_.value_or(config_.mounting.roll),
               roll = random() % 2 ? expected_roll : expected_roll + 0.12 * chance;
  if (kind == 0) return through_three(random);
  if (kind == 1) return through_two(random, roll);
  const double spread = config_.mounting.heightTolerance,
               height = config_.mounting.height * (1 + spread * (static_cast<double>(random() % 2001) / 1000 - 1));
  return view.calibrated() && height > 0 ? through_one(random, view, roll, height) : through_two(random, expected_roll);
}

double PlaneSearch::likely(const FloorPlane& plane, Plane kind, const StereoView& view, const Expected* last) const {
  if (!(plane.down > 1e-4) || std::abs(plane.across) > std::tan(most_roll) * plane.down) return 0;
  if (!view.calibrated()) return 1;
  const PlanePose pose = pose_of(plane, view);
  if (!(pose.height > least_height && pose.height < most_height && std::abs(pose.pitch) < most_pitch)) return 0;
  const double height = config_.mounting.height, pitch = config_.expected_pitch();
  if (mounted_ && kind == Plane::guess && !within_mounting(pose)) return 0;
  if (trusted_ && !drivable(pose)) return 0;
  double likely = bell(pose.roll - config_.mounting.roll, roll_off);
  if (height > 0) likely *= bell(pose.height / height - 1, height_off);
  likely *= std::isnan(pitch) ? bell(pose.pitch - usual_pitch, usual_pitch_off) : bell(pose.pitch - pitch, pitch_off);
  if (last) {
    const PlanePose before = pose_of(last->plane, view);
    likely *= 0.5 + 0.5 * bell(pose.height / before.height - 1, last_height_off) * bell(pose.pitch - before.pitch, last->off) *
                        bell(pose.roll - before.roll, last->off);
  }
  return likely;
}

PlaneSearch::Found PlaneSearch::judge(const FloorPlane& plane, Plane kind, const StereoView& view, const Expected* last,
                                      double least) const {
  Found found{plane, {}, {}, likely(plane, kind, view, last)};
  if (found.score <= 0) return found;
  const kernels::DisparityPlane single{static_cast<float>(plane.across), static_cast<float>(plane.down), static_cast<float>(plane.middle)};
  found.feet = machine_.kernels.count_on_plane(feet_.points(), feet_.n, single, plane_reach);
  const double feet = static_cast<double>(found.feet.on) - static_cast<double>(found.feet.beyond);
  // With so many more points on it.
  const auto score_of = [&](size_t more) {
    return found.score *
           std::max(0.0, found.all.on + static_cast<double>(more) - price_of_beyond * found.all.beyond + weight_of_feet * feet);
  };
  for (size_t from = 0; from < all_.n; from += points_at_once) {
    // Were all that are left on it, would it be worth going on?
    if (score_of(all_.n - from) <= least) return {plane, {}, {}, 0};
    const kernels::PlaneCount part =
        machine_.kernels.count_on_plane(all_.points(from), std::min(points_at_once, all_.n - from), single, plane_reach);
    found.all.on += part.on;
    found.all.beyond += part.beyond;
  }
  found.score = score_of(0);
  return found;
}

std::optional<PlaneSearch::Found> PlaneSearch::search(const StereoView& view, uint64_t seed, const Expected* last, bool trusted) {
  if (all_.n < 3) return std::nullopt;
  Random random(static_cast<uint32_t>(seed % 2147483646 + 1));
  last_roll_.reset();
  if (last) last_roll_ = std::atan2(last->plane.across, last->plane.down);
  mounted_ = view.calibrated() && config_.mounting.height > 0;
  trusted_ = mounted_ && trusted;
  if (mounted_) {
    const auto found = try_planes(view, random, last);
    if (found && holds(*found)) return found;
    mounted_ = false;
  }
  return try_planes(view, random, last);
}

std::optional<PlaneSearch::Found> PlaneSearch::try_planes(const StereoView& view, Random& random, const Expected* last) {
  std::array<Found, kept> best{};
  size_t count = 0;
  const auto keep = [&](const Found& found) {
    if (found.score <= 0) return;
    size_t i = count < kept ? count++ : kept - 1;
    if (i == kept - 1 && best[i].score >= found.score) return;
    for (; i > 0 && best[i - 1].score < found.score; --i) best[i] = best[i - 1];
    best[i] = found;
  };
  const auto worst_kept = [&] { return count < kept ? 0.0 : best[kept - 1].score; };
  if (last) keep(judge(last->plane, Plane::fit, view, last));
  for (int kind = 0; kind < 3; ++kind) {
    for (int i = 0; i < tries_of_kind[kind]; ++i) {
      if (const auto plane = draw(kind, random, view)) keep(judge(*plane, Plane::guess, view, last, worst_kept()));
    }
  }
  std::optional<Found> winner;
  for (size_t i = 0; i < count; ++i) {
    // What a fit makes of a guess counts, not the guess: a guess is as near as it may be to what was expected, and far off.
    FloorPlane plane = best[i].plane;
    for (const double wider : {1.5, 1.2}) plane = fitted(plane, part_of(few_), wider, machine_.kernels);
    const Found found = judge(plane, Plane::fit, view, last);
    if (found.score > 0 && (!winner || found.score > winner->score)) winner = found;
  }
  if (!winner) return winner;
  const FloorPlane near = settled(winner->plane, part_of(few_), most_fits, machine_.kernels);
  const Found exact = judge(settled(near, part_of(all_), most_fits, machine_.kernels), Plane::fit, view, last);
  if (exact.score > as_good * winner->score) return exact;
  const Found nearer = judge(settled(winner->plane, part_of(all_), few_fits, machine_.kernels), Plane::fit, view, last);
  return nearer.score > 0 ? nearer : winner;
}

}  // namespace vdisp
