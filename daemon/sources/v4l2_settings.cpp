// v4l2_settings.cpp: what a device of Video4Linux2 is asked for: pixels, size, rate, exposure.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <system_error>

#include "daemon/sources/raw_pixels.h"
#include "daemon/sources/v4l2_camera.h"

namespace vdisp {
namespace {

constexpr double exposure_unit_us = 100;  // of V4L2_CID_EXPOSURE_ABSOLUTE

struct Kind {
  uint32_t code;
  FramePixels pixels;
  const char *key, *bayer;
};
/// In the order in which `pixels = auto` takes them: what costs least on the way to gray first.
constexpr std::array<Kind, 14> kinds{{{V4L2_PIX_FMT_GREY, FramePixels::gray8, "gray8", ""},
                                      {V4L2_PIX_FMT_YUYV, FramePixels::yuyv, "yuyv", ""},
                                      {V4L2_PIX_FMT_UYVY, FramePixels::uyvy, "uyvy", ""},
                                      {V4L2_PIX_FMT_Y10, FramePixels::gray10, "gray10", ""},
                                      {V4L2_PIX_FMT_Y12, FramePixels::gray12, "gray12", ""},
                                      {V4L2_PIX_FMT_Y16, FramePixels::gray16, "gray16", ""},
                                      {V4L2_PIX_FMT_RGB24, FramePixels::rgb8, "rgb8", ""},
                                      {V4L2_PIX_FMT_BGR24, FramePixels::bgr8, "rgb8", ""},
                                      {V4L2_PIX_FMT_MJPEG, FramePixels::jpeg, "jpeg", ""},
                                      {V4L2_PIX_FMT_JPEG, FramePixels::jpeg, "jpeg", ""},
                                      {V4L2_PIX_FMT_SRGGB8, FramePixels::bayer8, "bayer8", "rggb"},
                                      {V4L2_PIX_FMT_SBGGR8, FramePixels::bayer8, "bayer8", "bggr"},
                                      {V4L2_PIX_FMT_SGRBG8, FramePixels::bayer8, "bayer8", "grbg"},
                                      {V4L2_PIX_FMT_SGBRG8, FramePixels::bayer8, "bayer8", "gbrg"}}};

std::string four_letters(uint32_t code) {
  std::string text;
  for (int i = 0; i < 4; ++i) text += static_cast<char>(code >> (8 * i) & 127);
  return text;
}

std::string size_text(uint32_t width, uint32_t height) { return std::to_string(width) + "x" + std::to_string(height); }

}  // namespace

std::vector<uint32_t> V4l2Camera::offered() {
  std::vector<uint32_t> found;
  v4l2_fmtdesc description{};
  description.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  while (system_.control(file_, VIDIOC_ENUM_FMT, &description) == 0) {
    found.push_back(description.pixelformat);
    ++description.index;
  }
  return found;
}

std::string V4l2Camera::sizes_of(uint32_t pixels) {
  std::string text;
  v4l2_frmsizeenum size{};
  size.pixel_format = pixels;
  for (; system_.control(file_, VIDIOC_ENUM_FRAMESIZES, &size) == 0; ++size.index) {
    if (size.type != V4L2_FRMSIZE_TYPE_DISCRETE)
      return size_text(size.stepwise.min_width, size.stepwise.min_height) + " to " +
             size_text(size.stepwise.max_width, size.stepwise.max_height);
    text += (text.empty() ? "" : ", ") + size_text(size.discrete.width, size.discrete.height);
  }
  return text.empty() ? "sizes that it does not tell" : text;
}

v4l2_format V4l2Camera::choose_format(FrameFormat& format) {
  const std::vector<uint32_t> has = offered();
  const std::string& wanted = config_.camera.pixels;
  const Kind* chosen = nullptr;
  std::string list;
  for (const uint32_t code : has) list += (list.empty() ? "" : ", ") + four_letters(code);
  for (const Kind& kind : kinds)
    if (!chosen && (wanted == "auto" || wanted == kind.key) && std::find(has.begin(), has.end(), kind.code) != has.end()) chosen = &kind;
  if (!chosen)
    refuse(CameraFault::unsupported,
           "it gives no pixels of kind " + wanted + " ([camera] pixels); it has " + (list.empty() ? "none" : list));
  v4l2_format setting{};
  setting.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (system_.control(file_, VIDIOC_G_FMT, &setting) < 0)
    refuse(CameraFault::failed, "VIDIOC_G_FMT: " + std::system_category().message(errno));
  const uint32_t views = config_.camera.views == "beside" ? 2 : 1;
  const auto width = static_cast<uint32_t>(config_.image_source.width) * views, height = static_cast<uint32_t>(config_.image_source.height);
  v4l2_pix_format& pix = setting.fmt.pix;
  if (width != 0) pix.width = width;
  if (height != 0) pix.height = height;
  pix.pixelformat = chosen->code;
  pix.field = V4L2_FIELD_NONE;
  pix.bytesperline = 0;
  if (system_.control(file_, VIDIOC_S_FMT, &setting) < 0)
    refuse(errno == EBUSY ? CameraFault::busy : CameraFault::failed,
           errno == EBUSY ? "another program uses it" : "VIDIOC_S_FMT: " + std::system_category().message(errno));
  if ((width != 0 && pix.width != width) || (height != 0 && pix.height != height) || pix.pixelformat != chosen->code ||
      pix.width % views != 0)
    refuse(CameraFault::unsupported, "asked for " + size_text(width, height) + " " + four_letters(chosen->code) + " it gives " +
                                         size_text(pix.width, pix.height) + " " + four_letters(pix.pixelformat) + "; it has " +
                                         sizes_of(chosen->code));
  format.pixels = chosen->pixels;
  format.views = views == 2 ? FrameViews::beside : FrameViews::one;
  format.width = static_cast<int>(pix.width / views);
  format.height = static_cast<int>(pix.height);
  format.stride = pix.bytesperline;
  if (chosen->pixels != FramePixels::jpeg)
    format.stride = std::max<ptrdiff_t>(format.stride, ptrdiff_t{format.width} * raw_pixel_bytes(format));
  format.bayer = chosen->bayer;
  return setting;
}

/// What the camera is set to where it takes no other.
void V4l2Camera::set_rate(FrameFormat& format) {
  v4l2_streamparm parameters{};
  parameters.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (system_.control(file_, VIDIOC_G_PARM, &parameters) < 0) return;
  v4l2_fract& time = parameters.parm.capture.timeperframe;
  const double rate = config_.image_source.rate;
  if (rate > 0) {
    time = {1000, static_cast<uint32_t>(std::lround(rate * 1000))};
    if (system_.control(file_, VIDIOC_S_PARM, &parameters) < 0) return;
  }
  if (time.denominator != 0) format.period_s = static_cast<double>(time.numerator) / time.denominator;
}

bool V4l2Camera::set(uint32_t control, int value) noexcept {
  v4l2_control setting{control, value};
  return system_.control(file_, VIDIOC_S_CTRL, &setting) == 0;
}

bool V4l2Camera::range(uint32_t control, int& least, int& most) noexcept {
  v4l2_queryctrl query{};
  query.id = control;
  if (system_.control(file_, VIDIOC_QUERYCTRL, &query) < 0 || (query.flags & V4L2_CTRL_FLAG_DISABLED)) return false;
  least = query.minimum;
  most = query.maximum;
  return true;
}

void V4l2Camera::prepare_exposure() {
  int least = 0, most = 0;
  exposure_us_ = longest_exposure_us_ = 0;
  gain_least_ = gain_most_ = 0;
  if (range(V4L2_CID_EXPOSURE_ABSOLUTE, least, most)) longest_exposure_us_ = most * exposure_unit_us;
  if (!range(V4L2_CID_GAIN, gain_least_, gain_most_)) gain_least_ = gain_most_ = 0;
  const camera_section& wanted = config_.camera;
  if (wanted.exposeBy == "camera") {
    // A webcam that lengthens exposures in the dark halves its rate, and no pair is one any more.
    if (!set(V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_APERTURE_PRIORITY)) set(V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_AUTO);
    set(V4L2_CID_EXPOSURE_AUTO_PRIORITY, 0);
    return;
  }
  if (!expose(wanted.exposure, wanted.gain))
    refuse(CameraFault::unsupported, "it lets nobody set its exposure; [camera] exposeBy must be camera");
}

bool V4l2Camera::expose(double exposure_us, double gain_db) noexcept {
  set(V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL);
  set(V4L2_CID_AUTOGAIN, 0);
  if (!set(V4L2_CID_EXPOSURE_ABSOLUTE, std::max(1, static_cast<int>(std::lround(exposure_us / exposure_unit_us))))) return false;
  exposure_us_ = exposure_us;
  if (gain_most_ > gain_least_)
    set(V4L2_CID_GAIN,
        gain_least_ + static_cast<int>(std::lround((gain_most_ - gain_least_) * std::min(gain_db / v4l2_gain_range_db, 1.0))));
  return true;
}

}  // namespace vdisp
