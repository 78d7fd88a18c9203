// floor.cpp: points, two at random, the line most points lie near, and what it says of the camera.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/floor.h"

#include <algorithm>
#include <cmath>

#include "daemon/stages/projection.h"

namespace vdisp {

std::vector<ImageSpec> Floor::check(std::span<const ImageSpec> in) {
  if (in.size() != 1) throw FormatError("takes the v-disparity, was given " + std::to_string(in.size()) + " images");
  require(in[0], Pixel::count16, "the v-disparity");
  const size_t cells = static_cast<size_t>(in[0].width) * in[0].height;
  columns_.resize(cells);
  rows_.resize(cells);
  votes_.resize(cells);
  return {{Pixel::line16, 0, in[0].width, 1}, record_spec<FloorModel>()};
}

Outcome Floor::process(std::span<const Image* const> in, std::span<Image* const> out) noexcept {
  const Image& vdisparity = *in[0];
  FloorModel& model = make_record<FloorModel>(*out[1]);
  model.model = FloorKind::line;
  model.pitch_rad = model.roll_rad = model.height_m = std::nan("");
  collect_points(vdisparity);
  model.points = static_cast<uint32_t>(size_);

  Line line{};
  if (size_ < static_cast<size_t>(config_.floor.minRansac)) {
    model.reason = Reason::few_points;
  } else if (!search(vdisparity.sequence, line)) {
    model.reason = Reason::no_floor_line;
  }
  if (model.reason != Reason::none) {
    model.state = FloorState::lost;
    out[0]->reason = out[1]->reason = model.reason;
    return Outcome::invalid;
  }
  line = refine(line);
  describe(vdisparity, line, model);
  int16_t* rows = out[0]->row<int16_t>(0);
  for (int column = 0; column < out[0]->spec.width; ++column)
    rows[column] = static_cast<int16_t>(std::lround(std::clamp(line.slope * column + line.row0, -32000.0, 32000.0)));
  return Outcome::valid;
}

void Floor::collect_points(const Image& vdisparity) noexcept {
  size_ = 0;
  const int threshold = config_.floor.minVotes;
  for (int v = 0; v < vdisparity.spec.height; ++v) {
    const int16_t* votes = vdisparity.row<int16_t>(v);
    for (int column = 0; column < vdisparity.spec.width; ++column) {
      if (votes[column] <= threshold) continue;
      columns_[size_] = static_cast<float>(column);
      rows_[size_] = static_cast<float>(v);
      votes_[size_++] = votes[column];
    }
  }
}

bool Floor::search(uint64_t seed, Line& best) noexcept {
  std::minstd_rand random(static_cast<uint32_t>(seed % 2147483646 + 1));
  const double least = std::tan(config_.floor.anglefloorMin), most = std::tan(config_.floor.anglefloorMax);
  size_t best_count = 0;
  for (int i = 0; i < config_.floor.iterRansac; ++i) {
    const size_t p = random() % size_, q = random() % size_;
    const double run = static_cast<double>(columns_[q]) - static_cast<double>(columns_[p]);
    if (run == 0) continue;
    const double slope = (static_cast<double>(rows_[q]) - static_cast<double>(rows_[p])) / run;
    if (!(slope > least && slope < most)) continue;
    const Line line{slope, static_cast<double>(rows_[p]) - slope * static_cast<double>(columns_[p])};
    const size_t count = count_near(line);
    if (count > best_count) {
      best_count = count;
      best = line;
    }
  }
  return best_count > 0;
}

size_t Floor::count_near(const Line& line) const noexcept {
  const float slope = static_cast<float>(line.slope), row0 = static_cast<float>(line.row0);
  const float reach = static_cast<float>(config_.floor.distThres * std::sqrt(1 + line.slope * line.slope));
  uint32_t count = 0;
  for (size_t i = 0; i < size_; ++i) count += std::abs(slope * columns_[i] + row0 - rows_[i]) < reach;
  return count;
}

Floor::Line Floor::refine(Line line) const noexcept {
  for (int round = 0; round < 3; ++round) {
    const double reach = config_.floor.distThres * std::sqrt(1 + line.slope * line.slope);
    double w = 0, x = 0, y = 0, xx = 0, xy = 0;
    for (size_t i = 0; i < size_; ++i) {
      const double column = columns_[i], row = rows_[i], vote = votes_[i];
      if (std::abs(line.slope * column + line.row0 - row) >= reach) continue;
      w += vote;
      x += vote * column;
      y += vote * row;
      xx += vote * column * column;
      xy += vote * column * row;
    }
    const double spread = w * xx - x * x;
    if (spread <= 0) return line;
    const double slope = (w * xy - x * y) / spread;
    // A refinement that leaves the permitted angles is none.
    if (!(slope > std::tan(config_.floor.anglefloorMin) && slope < std::tan(config_.floor.anglefloorMax))) return line;
    line = {slope, (y - slope * x) / w};
  }
  return line;
}

void Floor::describe(const Image& vdisparity, const Line& line, FloorModel& model) const noexcept {
  const CameraGeometry& g = vdisparity.camera;
  const StereoView view = stereo_view(vdisparity);
  double near = 0, all = 0;
  const double reach = config_.floor.distThres * std::sqrt(1 + line.slope * line.slope);
  model.points = 0;
  for (size_t i = 0; i < size_; ++i) {
    const double vote = votes_[i];
    all += vote;
    if (std::abs(line.slope * static_cast<double>(columns_[i]) + line.row0 - static_cast<double>(rows_[i])) >= reach) continue;
    near += vote;
    ++model.points;
  }
  model.state = FloorState::found;
  model.confidence = near / all;
  model.a = line.slope;
  // The line counts columns; b is the row at d' = 0.
  model.b = line.row0 + line.slope * 16 * (static_cast<double>(g.cx_offset) - g.min_disparity);
  if (!view.calibrated()) {
    model.reason = Reason::no_calibration;
    return;
  }
  const FloorPose pose = floor_pose(view, {16 * model.a, model.b});
  model.pitch_rad = pose.pitch;
  model.height_m = pose.height;
  const auto& mounting = config_.mounting;
  const double expected = config_.expected_pitch();
  const bool height_differs = mounting.height > 0 && std::abs(pose.height - mounting.height) > mounting.heightTolerance * mounting.height;
  const bool pitch_differs = !std::isnan(expected) && std::abs(pose.pitch - expected) > mounting.pitchTolerance;
  model.mounting_differs = height_differs || pitch_differs;
}

}  // namespace vdisp
