// floor.h: stages `floor` and `floor_model`: the floor as a line in the v-disparity, by RANSAC (paper 3.8, algorithm 2).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "config/config.h"
#include "daemon/core/processor.h"
#include "daemon/kernels/aligned.h"
#include "daemon/stages/machine.h"
#include "ipc/records.h"

namespace vdisp {

/// count16 to line16 (row of the floor for each column, not clipped to the image) and the record FloorModel.
///
/// Where it departs from algorithm 2: the best line is remembered (the paper never updates no_point_best); the vote threshold is a
/// parameter; the best line is then fitted to its points by least squares, each with its votes as weight, because two cells alone
/// give the line only to a cell; a row outside the image stays what it is (the paper writes 0, which is a row); the random numbers
/// of a frame follow from its sequence number, so that a frame gives the same floor every time.
class Floor final : public ImageProcessor {
 public:
  Floor(Machine& machine, const Config& config) : machine_(machine), config_(config) {}
  std::vector<ImageSpec> check(std::span<const ImageSpec> in) override;
  Outcome process(std::span<const Image* const> in, std::span<Image* const> out) noexcept override;

 private:
  struct Line {
    double slope, row0;  // row = slope * column + row0
    bool operator==(const Line&) const = default;
  };
  bool search(uint64_t seed, Line& best) noexcept;
  kernels::NearSums sum_near(const Line& line) noexcept;
  kernels::NearSums refine(Line& line) noexcept;
  void describe(const Image& vdisparity, const Line& line, const kernels::NearSums& sums, FloorModel& model) noexcept;
  kernels::Points points() { return {columns_.data(), rows_.data(), votes_.data()}; }

  Machine& machine_;
  const Config& config_;
  kernels::Aligned<float> columns_, rows_, votes_;  // the points; sized once, size_ of them in use
  size_t size_ = 0;
};

}  // namespace vdisp
