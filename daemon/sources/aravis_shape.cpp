// aravis_shape.cpp: which pixels and which part of the sensor: asked for, looked at, and what there is listed.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstring>
#include <memory>
#include <vector>

#include "daemon/sources/aravis_setup.h"
#include "daemon/sources/raw_pixels.h"

namespace vdisp {
namespace {

/// In the order in which `pixels = auto` prefers them. Names as in the PFNC, ours as in [camera] pixels.
struct Format {
  ArvPixelFormat code;
  FramePixels pixels;
  const char *word, *bayer;
};
constexpr Format formats[] = {
    {ARV_PIXEL_FORMAT_MONO_8, FramePixels::gray8, "gray8", ""},
    {ARV_PIXEL_FORMAT_MONO_10, FramePixels::gray10, "gray10", ""},
    {ARV_PIXEL_FORMAT_MONO_12, FramePixels::gray12, "gray12", ""},
    {ARV_PIXEL_FORMAT_MONO_16, FramePixels::gray16, "gray16", ""},
    {ARV_PIXEL_FORMAT_BAYER_RG_8, FramePixels::bayer8, "bayer8", "rggb"},
    {ARV_PIXEL_FORMAT_BAYER_BG_8, FramePixels::bayer8, "bayer8", "bggr"},
    {ARV_PIXEL_FORMAT_BAYER_GR_8, FramePixels::bayer8, "bayer8", "grbg"},
    {ARV_PIXEL_FORMAT_BAYER_GB_8, FramePixels::bayer8, "bayer8", "gbrg"},
    {ARV_PIXEL_FORMAT_RGB_8_PACKED, FramePixels::rgb8, "rgb8", ""},
    {ARV_PIXEL_FORMAT_BGR_8_PACKED, FramePixels::bgr8, "rgb8", ""},
    {ARV_PIXEL_FORMAT_YUV_422_YUYV_PACKED, FramePixels::yuyv, "yuyv", ""},
    {ARV_PIXEL_FORMAT_YUV_422_PACKED, FramePixels::uyvy, "uyvy", ""},
};

[[noreturn]] void refuse(const std::string& what) { throw CameraError(CameraFault::unsupported, what); }

std::vector<ArvPixelFormat> pixel_formats(ArvCamera* camera, const std::string& name) {
  AravisError error;
  guint count = 0;
  const std::unique_ptr<gint64, void (*)(void*)> codes(arv_camera_dup_available_pixel_formats(camera, &count, error), g_free);
  error.check(name, "asked for its pixel formats");
  std::vector<ArvPixelFormat> found;
  for (guint i = 0; i < count; ++i) found.push_back(static_cast<ArvPixelFormat>(codes.get()[i]));
  return found;
}

/// "gray8 (Mono8), bayer8 (BayerRG8)", and what it has besides, which nobody here reads.
std::string supported(ArvCamera* camera, const std::vector<ArvPixelFormat>& has) {
  std::string list, others;
  for (const Format& format : formats)
    if (std::find(has.begin(), has.end(), format.code) != has.end())
      list += (list.empty() ? "" : ", ") + std::string(format.word) + (*format.bayer ? " (" + std::string(format.bayer) + ")" : "");
  guint count = 0;
  const std::unique_ptr<const char*, void (*)(void*)> names(arv_camera_dup_available_pixel_formats_as_strings(camera, &count, nullptr),
                                                            g_free);
  if (list.empty())
    for (guint i = 0; i < count; ++i) others += (i ? ", " : "") + std::string(names.get()[i]);
  return list.empty() ? "it has none that can be read, only " + others : "it has " + list;
}

const Format& set_pixels(ArvCamera* camera, const Config& config, const std::string& name) {
  const std::string& word = config.camera.pixels;
  const std::string& bayer = config.image_source.bayer;
  const std::vector<ArvPixelFormat> has = pixel_formats(camera, name);
  // With a mosaic configured only that mosaic will do: gray taken for one would be turned into noise.
  const auto fits = [&](const Format& format) {
    if (word != "auto" && word != format.word) return false;
    return bayer == "none" || bayer == format.bayer;
  };
  const Format* chosen = nullptr;
  for (const Format& format : formats)
    if (!chosen && fits(format) && std::find(has.begin(), has.end(), format.code) != has.end()) chosen = &format;
  if (!chosen)
    refuse(name + ": [camera] pixels = " + word + (bayer == "none" ? "" : " with [image source] bayer = " + bayer) + " cannot be had; " +
           supported(camera, has));
  AravisError error;
  arv_camera_set_pixel_format(camera, chosen->code, error);
  error.check(name, "set to the pixel format");
  return *chosen;
}

struct Bounds {
  int least = 0, most = 0, step = 1;
  bool hold(int value) const { return value >= least && value <= most && (value - least) % std::max(step, 1) == 0; }
  std::string words() const {
    return std::to_string(least) + " to " + std::to_string(most) + (step > 1 ? " in steps of " + std::to_string(step) : "");
  }
};

/// The middle of the sensor, where a size is configured; else as the camera is set.
void set_region(ArvCamera* camera, const Config& config, const std::string& name, int views) {
  const int width = config.image_source.width * views, height = config.image_source.height;
  if (width == 0 && height == 0) return;
  AravisError error;
  gint x = 0, y = 0, now_width = 0, now_height = 0, sensor_width = 0, sensor_height = 0;
  const bool offsets = arv_camera_is_region_offset_available(camera, nullptr);
  if (offsets) arv_camera_set_region(camera, 0, 0, -1, -1, nullptr);  // else they bound the size
  arv_camera_get_region(camera, &x, &y, &now_width, &now_height, error);
  error.check(name, "asked for its image size");
  const int wanted_width = width ? width : now_width, wanted_height = height ? height : now_height;
  Bounds widths, heights;
  arv_camera_get_width_bounds(camera, &widths.least, &widths.most, nullptr);
  arv_camera_get_height_bounds(camera, &heights.least, &heights.most, nullptr);
  widths.step = arv_camera_get_width_increment(camera, nullptr);
  heights.step = arv_camera_get_height_increment(camera, nullptr);
  if (!widths.hold(wanted_width) || !heights.hold(wanted_height))
    refuse(name + ": an image of " + std::to_string(wanted_width) + "x" + std::to_string(wanted_height) +
           (views == 2 ? " (both views)" : "") + " cannot be had; widths are " + widths.words() + ", heights " + heights.words());
  arv_camera_set_region(camera, -1, -1, wanted_width, wanted_height, error);
  error.check(name, "set to the image size");
  arv_camera_get_sensor_size(camera, &sensor_width, &sensor_height, nullptr);
  if (!offsets || sensor_width < wanted_width || sensor_height < wanted_height) return;
  const int step_x = std::max(arv_camera_get_x_offset_increment(camera, nullptr), 1);
  const int step_y = std::max(arv_camera_get_y_offset_increment(camera, nullptr), 1);
  arv_camera_set_region(camera, (sensor_width - wanted_width) / 2 / step_x * step_x, (sensor_height - wanted_height) / 2 / step_y * step_y,
                        -1, -1, error);
  error.check(name, "set to the middle of its sensor");
}

}  // namespace

FrameFormat set_shape(ArvCamera* camera, const Config& config, const std::string& name) {
  FrameFormat format;
  const std::string& views = config.camera.views;
  format.views = views == "one" ? FrameViews::one : views == "beside" ? FrameViews::beside : FrameViews::by_turns;
  const int count = format.views == FrameViews::one ? 1 : 2;
  const Format& pixels = set_pixels(camera, config, name);
  format.pixels = pixels.pixels;
  format.bayer = pixels.bayer;
  set_region(camera, config, name, count);
  AravisError error;
  gint x = 0, y = 0, width = 0, height = 0;
  arv_camera_get_region(camera, &x, &y, &width, &height, error);
  error.check(name, "asked for its image size");
  if (width % count != 0)
    refuse(name + ": both views side by side in " + std::to_string(width) + " columns, an odd number; set [image source] width");
  format.width = width / count;
  format.height = height;
  format.stride = static_cast<ptrdiff_t>(format.width) * raw_pixel_bytes(format);
  return format;
}

}  // namespace vdisp
