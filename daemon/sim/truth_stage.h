// truth_stage.h: what the stages of truth.cpp and true_ground.cpp share.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "config/config.h"
#include "daemon/core/driver.h"
#include "daemon/sim/simulator.h"

namespace vdisp::sim {

/// One image from the simulator's view of the frame that the input was made in.
class TruthStage : public ImageProcessor {
 public:
  TruthStage(Simulator& simulator, const Config& config) : config_(config), view_(simulator.calibration().view), simulator_(simulator) {}

  std::vector<ImageSpec> check(std::span<const ImageSpec> in) override {
    if (in.size() != 1) throw FormatError("takes one image, was given " + std::to_string(in.size()));
    require(in[0], Pixel::gray8, "the camera image");
    return {make(in[0])};
  }
  Outcome process(std::span<const Image* const> in, std::span<Image* const> out) noexcept override {
    const int64_t period = frame_period_ns(config_.sim);
    fill(simulator_.truth(static_cast<uint64_t>((in[0]->timestamp_ns + period / 2) / period)), *out[0]);
    return Outcome::valid;
  }

 protected:
  virtual ImageSpec make(const ImageSpec& camera) const = 0;
  virtual void fill(const TruthView& truth, Image& out) const noexcept = 0;
  /// The rectified view that the truth is of.
  CameraGeometry geometry() const {
    return {static_cast<float>(view_.f),         static_cast<float>(view_.cx),
            static_cast<float>(view_.cy),        static_cast<float>(view_.baseline),
            static_cast<float>(view_.cx_offset), config_.image_source.minDisparity,
            config_.image_source.ndisp,          {}};
  }
  const Config& config_;
  const StereoView view_;
  Simulator& simulator_;
};

/// One that looks at the map's cells.
class TruthGrid : public TruthStage {
 public:
  using TruthStage::TruthStage;

 protected:
  int rows() const { return static_cast<int>(std::lround(config_.map.range / config_.map.cell)); }
  int columns() const { return static_cast<int>(std::lround(config_.map.width / config_.map.cell)); }
  ImageSpec grid_spec(Pixel pixel) const { return {pixel, 0, static_cast<uint16_t>(columns()), static_cast<uint16_t>(rows())}; }
  GridGeometry grid(const TruthView& truth) const {
    const auto cx = static_cast<float>(view_.cx), along = static_cast<float>(view_.f * std::cos(truth.scene.pitch_rad));
    const mounting_section& mounting = config_.mounting;
    return {static_cast<float>(config_.map.cell),
            static_cast<float>(rows()),
            static_cast<float>(columns()) / 2,
            -cx / along,
            (static_cast<float>(truth.width) - cx) / along,
            static_cast<uint32_t>(config_.map.minCount),
            0,
            static_cast<float>(mounting.x),
            static_cast<float>(mounting.y),
            static_cast<float>(mounting.yaw)};
  }
};

inline int16_t saturated(double value) { return static_cast<int16_t>(std::clamp(std::round(value), -32767.0, 32767.0)); }

/// Adds truth/height and truth/map_cells.
void add_ground_truth(Driver& driver, Handle camera, Simulator& simulator, const Config& config);

/// Adds truth/steering where there is a robot.
void add_true_steering(Driver& driver, Handle camera, Simulator& simulator);

}  // namespace vdisp::sim
