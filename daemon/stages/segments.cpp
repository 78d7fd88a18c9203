// segments.cpp: points, what hangs together, and what of it is high or steep.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/stages/segments.h"

#include <algorithm>
#include <cmath>

#include "daemon/stages/projection.h"

namespace vdisp {
namespace {

constexpr int rows_apart = 6;  // of 480, in proportion: nearer rows show the matcher's steps instead of the slope

}  // namespace

std::vector<ImageSpec> Segments::check(std::span<const ImageSpec> in) {
  if (in.size() != 2) throw FormatError("takes the disparity and the floor model, was given " + std::to_string(in.size()) + " images");
  require(in[0], Pixel::disparity16, "the disparity");
  require(in[1], Pixel::record, "the floor model");
  const size_t pixels = static_cast<size_t>(in[0].width) * in[0].height;
  up_.resize(pixels);
  ahead_.resize(pixels);
  kind_.resize(pixels);
  parent_.resize(pixels);
  size_.resize(pixels);
  return {{Pixel::gray8, 0, in[0].width, in[0].height}, {Pixel::mask8, 0, in[0].width, in[0].height}};
}

Outcome Segments::process(std::span<const Image* const> in, std::span<Image* const> out) noexcept {
  const Image& disparity = *in[0];
  double pitch = config_.limit.angRot;
  if (config_.automatic_pitch()) pitch = in[1]->valid() ? in[1]->row<FloorModel>(0)->pitch_rad : std::nan("");
  out[0]->reason = no_metres(disparity, pitch);
  if (out[0]->reason != Reason::none) return Outcome::invalid;
  const int width = disparity.spec.width, height = disparity.spec.height;
  measure(disparity, pitch);
  join(disparity);
  number(width, height);
  const double max_height = config_.limit.max_height, max_slope = config_.floor.maxSlope;
  for (int v = 0, i = 0; v < height; ++v) {
    uint8_t *segment = out[0]->row<uint8_t>(v), *obstacle = out[1]->row<uint8_t>(v);
    for (int u = 0; u < width; ++u, ++i) {
      segment[u] = obstacle[u] = 0;
      if (kind_[static_cast<size_t>(i)] == Kind::none) continue;
      const int name = -1 - size_[static_cast<size_t>(root(i))];
      if (name < 0) continue;
      segment[u] = static_cast<uint8_t>(1 + name % 255);
      obstacle[u] = segments_[static_cast<size_t>(name)].obstacle(max_height, max_slope) ? 255 : 0;
    }
  }
  return Outcome::valid;
}

void Segments::measure(const Image& disparity, double pitch) noexcept {
  const StereoView view = stereo_view(disparity);
  const kernels::Search search = search_of(disparity.camera, 16 * disparity.camera.disparities);
  size_t i = 0;
  for (int v = 0; v < disparity.spec.height; ++v) {
    const int16_t* d = disparity.row<int16_t>(v);
    for (int u = 0; u < disparity.spec.width; ++u, ++i) {
      kind_[i] = search.counts(d[u]) ? Kind::flat : Kind::none;
      if (kind_[i] == Kind::none) continue;
      const Point at = horizontal(view.point(u, v, d[u] / 16.0), pitch);
      up_[i] = static_cast<float>(-at.y);
      ahead_[i] = static_cast<float>(at.z);
    }
  }
  i = 0;
  for (int v = 0; v < disparity.spec.height; ++v) {
    for (int u = 0; u < disparity.spec.width; ++u, ++i) {
      if (kind_[i] != Kind::none) kind_[i] = kind(disparity, u, v);
    }
  }
}

/// By the pixels some rows over and below it, where they belong together.
Segments::Kind Segments::kind(const Image& disparity, int u, int v) const noexcept {
  const int height = disparity.spec.height, width = disparity.spec.width, apart = std::max(rows_apart * height / 480, 2);
  const int here = disparity.row<int16_t>(v)[u], limit = 4 * config_.image_source.SpeckleDiff * apart;
  int ends[2] = {v, v};
  for (int side = 0; side < 2; ++side) {
    const int other = side == 0 ? v - apart : v + apart;
    if (other < 0 || other >= height || kind_[static_cast<size_t>(other * width + u)] == Kind::none) continue;
    if (std::abs(disparity.row<int16_t>(other)[u] - here) <= limit) ends[side] = other;
  }
  const auto top = static_cast<size_t>(ends[0] * width + u), bottom = static_cast<size_t>(ends[1] * width + u);
  const double rise = static_cast<double>(up_[top] - up_[bottom]), run = static_cast<double>(ahead_[top] - ahead_[bottom]);
  return std::abs(rise) > std::tan(config_.floor.maxSlope) * std::abs(run) ? Kind::steep : Kind::flat;
}

int Segments::root(int pixel) noexcept {
  while (parent_[static_cast<size_t>(pixel)] != pixel) {
    int& parent = parent_[static_cast<size_t>(pixel)];
    parent = parent_[static_cast<size_t>(parent)];
    pixel = parent;
  }
  return pixel;
}

void Segments::join(const Image& disparity) noexcept {
  const int width = disparity.spec.width, limit = 4 * config_.image_source.SpeckleDiff;
  for (int v = 0, i = 0; v < disparity.spec.height; ++v) {
    const int16_t *d = disparity.row<int16_t>(v), *over = disparity.row<int16_t>(std::max(v - 1, 0));
    for (int u = 0; u < width; ++u, ++i) {
      parent_[static_cast<size_t>(i)] = i;
      const Kind own = kind_[static_cast<size_t>(i)];
      if (own == Kind::none) continue;
      const auto take = [&](int other, int value) {
        if (kind_[static_cast<size_t>(other)] == own && std::abs(value - d[u]) <= limit)
          parent_[static_cast<size_t>(root(other))] = root(i);
      };
      if (u > 0) take(i - 1, d[u - 1]);
      if (v > 0) take(i - width, over[u]);
    }
  }
}

void Segments::number(int width, int height) noexcept {
  std::fill(size_.begin(), size_.end(), 0);
  const int pixels = width * height;
  for (int i = 0; i < pixels; ++i) {
    if (kind_[static_cast<size_t>(i)] != Kind::none) ++size_[static_cast<size_t>(root(i))];
  }
  size_t count = 0;
  for (int i = 0; i < pixels; ++i) {
    int& size = size_[static_cast<size_t>(i)];
    if (size <= config_.image_source.SpeckleSize || count == most) {
      size = 0;
      continue;
    }
    segments_[count] = {};
    size = -1 - static_cast<int>(count++);
  }
  for (int i = 0; i < pixels; ++i) {
    if (kind_[static_cast<size_t>(i)] == Kind::none) continue;
    const int name = -1 - size_[static_cast<size_t>(root(i))];
    if (name < 0) continue;
    Segment& s = segments_[static_cast<size_t>(name)];
    const double up = static_cast<double>(up_[static_cast<size_t>(i)]), ahead = static_cast<double>(ahead_[static_cast<size_t>(i)]);
    ++s.pixels;
    s.up += up;
    s.ahead += ahead;
    s.up2 += up * up;
    s.ahead2 += ahead * ahead;
    s.mixed += up * ahead;
  }
}

bool Segments::Segment::obstacle(double max_height, double max_slope) const {
  const double n = pixels, high2 = up2 / n - up / n * (up / n), far2 = ahead2 / n - ahead / n * (ahead / n),
               both = mixed / n - up / n * (ahead / n);
  return std::sqrt(12 * std::max(high2, 0.0)) > max_height || std::abs(std::atan2(2 * both, far2 - high2) / 2) > max_slope;
}

}  // namespace vdisp
