// floor.cpp: points, two at random, the line most points lie near, and what it says of the camera.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/floor.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "daemon/stages/projection.h"

namespace vdisp {

std::vector<ImageSpec> Floor::check(std::span<const ImageSpec> in) {
  if (in.size() != 1) throw FormatError("takes the v-disparity, was given " + std::to_string(in.size()) + " images");
  require(in[0], Pixel::count16, "the v-disparity");
  for (kernels::Aligned<float>* list : {&columns_, &rows_, &votes_})
    list->resize(kernels::point_room(static_cast<size_t>(in[0].width) * in[0].height));
  return {{Pixel::line16, 0, in[0].width, 1}, record_spec<FloorModel>()};
}

Outcome Floor::process(std::span<const Image* const> in, std::span<Image* const> out) noexcept {
  const Image& vdisparity = *in[0];
  FloorModel& model = make_record<FloorModel>(*out[1]);
  model.model = FloorKind::line;
  model.pitch_rad = model.roll_rad = model.height_m = std::nan("");
  model.steady_pitch_rad = model.steady_roll_rad = model.steady_height_m = std::nan("");
  model.gravity_pitch_rad = model.gravity_roll_rad = std::nan("");
  size_ = machine_.kernels.collect_points(plane<int16_t>(vdisparity), config_.floor.minVotes, points());
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
  const kernels::NearSums sums = refine(line);
  describe(vdisparity, line, sums, model);
  int16_t* rows = out[0]->row<int16_t>(0);
  for (int column = 0; column < out[0]->spec.width; ++column) {
    const double row = std::clamp(line.slope * column + line.row0, -32000.0, 32000.0);
    const int whole = static_cast<int>(row);
    const double rest = row - whole;
    rows[column] = static_cast<int16_t>(whole + (rest >= 0.5) - (rest <= -0.5));  // std::lround, without a call
  }
  return Outcome::valid;
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
    const float reach = static_cast<float>(config_.floor.distThres * std::sqrt(1 + slope * slope));
    const size_t count =
        machine_.kernels.count_near(points(), size_, static_cast<float>(line.slope), static_cast<float>(line.row0), reach, best_count);
    if (count > best_count) {
      best_count = count;
      best = line;
    }
  }
  return best_count > 0;
}

kernels::NearSums Floor::sum_near(const Line& line) noexcept {
  return machine_.kernels.sum_near(points(), size_, line.slope, line.row0,
                                   config_.floor.distThres * std::sqrt(1 + line.slope * line.slope));
}

/// Returns the sums of what lies near the refined line.
kernels::NearSums Floor::refine(Line& line) noexcept {
  const double least = std::tan(config_.floor.anglefloorMin), most = std::tan(config_.floor.anglefloorMax);
  kernels::NearSums sums = sum_near(line);
  for (int round = 0; round < 3; ++round) {
    const double spread = sums.votes * sums.column_column - sums.column * sums.column;
    if (spread <= 0) return sums;
    const double slope = (sums.votes * sums.column_row - sums.column * sums.row) / spread;
    // A refinement that leaves the permitted angles is none.
    if (!(slope > least && slope < most)) return sums;
    const Line refined{slope, (sums.row - slope * sums.column) / sums.votes};
    // The same line has the same points: there is nothing left to refine.
    if (refined == line) return sums;
    line = refined;
    sums = sum_near(line);
  }
  return sums;
}

void Floor::describe(const Image& vdisparity, const Line& line, const kernels::NearSums& sums, FloorModel& model) noexcept {
  const CameraGeometry& g = vdisparity.camera;
  const StereoView view = stereo_view(vdisparity);
  model.points = static_cast<uint32_t>(sums.count);
  model.state = FloorState::found;
  model.confidence = sums.votes / sums.all;
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
