// front_end.cpp: INTERIM until the stages of the branch are there.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/tools/train/front_end.h"

#include <algorithm>
#include <bit>
#include <opencv2/imgproc.hpp>

#include "daemon/stages/rectify.h"
#include "ipc/outlet.h"

namespace vdisp::train {

struct FrontEnd::Stages {
  Stages(const Recording& r, const snow::Settings& s)
      : recording(r),
        settings(s),
        raw{BufferOutlet(spec()), BufferOutlet(spec())},
        rect{BufferOutlet(spec()), BufferOutlet(spec())},
        disparity(ImageSpec{Pixel::disparity16, 0, uint16_t(s.width), uint16_t(s.height)}),
        depth(ImageSpec{Pixel::count16, 0, uint16_t(s.width), uint16_t(s.disparities)}) {
    if (!r.calibration().empty()) calibration = read_calibration(r.calibration());
    for (int i = 0; i < 2; ++i) {
      stage[i] = std::make_unique<Rectify>(i ? Side::right : Side::left, calibration, machine, config);
      stage[i]->accept(spec());
    }
  }
  ImageSpec spec() const { return {Pixel::gray8, 0, uint16_t(recording.info().width), uint16_t(recording.info().height)}; }
  const Recording& recording;
  snow::Settings settings;
  Machine machine;
  Config config;
  std::optional<Calibration> calibration;
  BufferOutlet raw[2], rect[2];
  BufferOutlet disparity, depth;
  std::unique_ptr<Rectify> stage[2];
};

FrontEnd::FrontEnd(const Recording& recording, const snow::Settings& settings, Machine&)
    : stages_(std::make_unique<Stages>(recording, settings)) {}
FrontEnd::~FrontEnd() = default;

Reason FrontEnd::run(size_t pair) {
  Stages& s = *stages_;
  const int W = int(s.settings.width), H = int(s.settings.height), D = int(s.settings.disparities), B = int(s.settings.block);
  s.recording.read(pair, s.raw[0].loan(), s.raw[1].loan());
  cv::Mat census[2];
  for (int i = 0; i < 2; ++i) {
    s.stage[i]->filter(s.raw[i].loan(), s.rect[i].loan());
    Image& im = s.rect[i].loan();
    cv::Mat m(im.spec.height, im.spec.width, CV_8U, im.row<uint8_t>(0), im.spec.stride()), small;
    cv::resize(m, small, {W, H}, 0, 0, cv::INTER_AREA);
    if (s.settings.smooth == snow::Smooth::mean) cv::blur(small, small, {3, 3});
    if (s.settings.smooth == snow::Smooth::median) cv::medianBlur(small, small, 3);
    census[i].create(H, W, CV_8U);
    s.machine.kernels.census3x3({small.ptr(), W, H, W}, 0, H, {census[i].ptr(), W, H, W});
  }
  cv::Mat best(H, W, CV_32F, cv::Scalar(1e9f)), at = cv::Mat::zeros(H, W, CV_16S), sum = cv::Mat::zeros(H, W, CV_32F), dist(H, W, CV_8U),
                                                box;
  for (int d = 0; d < D; ++d) {
    for (int v = 0; v < H; ++v) {
      const uint8_t *a = census[0].ptr(v), *b = census[1].ptr(v);
      uint8_t* o = dist.ptr(v);
      for (int u = 0; u < W; ++u) o[u] = u < d ? 4 : uint8_t(std::popcount(unsigned(a[u] ^ b[u - d])));
    }
    cv::boxFilter(dist, box, CV_32F, {B, B});
    for (int v = 0; v < H; ++v) {
      float *m = best.ptr<float>(v), *t = sum.ptr<float>(v);
      const float* o = box.ptr<float>(v);
      int16_t* w = at.ptr<int16_t>(v);
      for (int u = 0; u < W; ++u) {
        t[u] += o[u];
        if (o[u] < m[u]) m[u] = o[u], w[u] = int16_t(d);
      }
    }
  }
  Image &disp = s.disparity.loan(), &depth = s.depth.loan();
  for (int d = 0; d < D; ++d) std::fill_n(depth.row<int16_t>(d), W, int16_t(0));
  for (int v = 0; v < H; ++v)
    for (int u = 0; u < W; ++u) {
      const bool ok = u >= D - 1 && sum.at<float>(v, u) / float(D) - best.at<float>(v, u) >= s.settings.confidence;
      const int16_t d = ok ? at.at<int16_t>(v, u) : int16_t(0);
      disp.row<int16_t>(v)[u] = int16_t(16 * d);
      ++depth.row<int16_t>(d)[u];
    }
  return Reason::none;
}

void FrontEnd::features(snow::Encoding encoding, std::span<uint8_t> pixels) const {
  BufferOutlet out(snow::feature_spec(encoding));
  Image& im = out.loan();
  snow::make_features(encoding, stages_->disparity.loan(), stages_->depth.loan(), int(stages_->settings.disparities), im);
  for (int y = 0; y < im.spec.height; ++y) std::copy_n(im.row<uint8_t>(y), im.spec.width, pixels.data() + y * im.spec.width);
}

}  // namespace vdisp::train
