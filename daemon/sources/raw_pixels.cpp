// raw_pixels.cpp: packed pixels by small loops, JPEG by libjpeg-turbo.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sources/raw_pixels.h"

#include <turbojpeg.h>

#include <cstring>
#include <vector>

namespace vdisp {
namespace {

/// BT.601, as cameras and JPEG have it.
uint8_t luminance(unsigned r, unsigned g, unsigned b) { return static_cast<uint8_t>((77 * r + 150 * g + 29 * b + 128) >> 8); }

/// `count` pixels of one row; `step`: bytes from a pixel of this view to the next.
void write_row(FramePixels pixels, const uint8_t* in, int step, int count, uint8_t* out) {
  const auto each = [&](auto value) {
    for (int x = 0; x < count; ++x) out[x] = value(in + static_cast<ptrdiff_t>(x) * step);
  };
  const auto word = [](const uint8_t* p, int bits) { return static_cast<uint8_t>((p[0] | p[1] << 8) >> (bits - 8)); };
  switch (pixels) {
    case FramePixels::gray8:
    case FramePixels::bayer8:
    case FramePixels::jpeg:
      if (step == 1) {
        std::memcpy(out, in, static_cast<size_t>(count));
        break;
      }
      [[fallthrough]];
    case FramePixels::yuyv: each([](const uint8_t* p) { return p[0]; }); break;
    case FramePixels::uyvy: each([](const uint8_t* p) { return p[1]; }); break;
    case FramePixels::gray10: each([&](const uint8_t* p) { return word(p, 10); }); break;
    case FramePixels::gray12: each([&](const uint8_t* p) { return word(p, 12); }); break;
    case FramePixels::gray16: each([&](const uint8_t* p) { return word(p, 16); }); break;
    case FramePixels::rgb8: each([](const uint8_t* p) { return luminance(p[0], p[1], p[2]); }); break;
    case FramePixels::bgr8: each([](const uint8_t* p) { return luminance(p[2], p[1], p[0]); }); break;
  }
}

int bytes_of(FramePixels pixels) {
  switch (pixels) {
    case FramePixels::rgb8:
    case FramePixels::bgr8: return 3;
    case FramePixels::gray8:
    case FramePixels::bayer8:
    case FramePixels::jpeg: return 1;
    default: return 2;
  }
}

}  // namespace

struct RawPixels::Jpeg {
  tjhandle decoder = tjInitDecompress();
  std::vector<uint8_t> gray;
};

RawPixels::RawPixels() : jpeg_(std::make_unique<Jpeg>()) {}
RawPixels::~RawPixels() { tjDestroy(jpeg_->decoder); }

int raw_pixel_bytes(const FrameFormat& format) {
  return format.pixels == FramePixels::jpeg ? 0 : bytes_of(format.pixels) * (format.views == FrameViews::one ? 1 : 2);
}

bool RawPixels::unpack_jpeg(const FrameFormat& format, const RawFrame& frame) noexcept {
  const int width = format.width * (format.views == FrameViews::one ? 1 : 2);
  const auto* bytes = reinterpret_cast<const unsigned char*>(frame.bytes);
  const auto size = static_cast<unsigned long>(frame.size);
  int found_width = 0, found_height = 0, sampling = 0, colours = 0;
  if (tjDecompressHeader3(jpeg_->decoder, bytes, size, &found_width, &found_height, &sampling, &colours) != 0) {
    problem_ = "damaged JPEG: " + std::string(tjGetErrorStr2(jpeg_->decoder));
    return false;
  }
  if (found_width != width || found_height != format.height) {
    problem_ = "a JPEG of " + std::to_string(found_width) + "x" + std::to_string(found_height) + ", needed is " + std::to_string(width) +
               "x" + std::to_string(format.height);
    return false;
  }
  jpeg_->gray.resize(static_cast<size_t>(width) * static_cast<size_t>(format.height));
  // A warning means that pixels were made up: no stereo from those.
  if (tjDecompress2(jpeg_->decoder, bytes, size, jpeg_->gray.data(), width, width, format.height, TJPF_GRAY, TJFLAG_STOPONWARNING) != 0) {
    problem_ = "damaged JPEG: " + std::string(tjGetErrorStr2(jpeg_->decoder));
    return false;
  }
  return true;
}

bool RawPixels::write(const FrameFormat& format, const RawFrame& frame, bool exchanged, std::span<const GrayView> views) noexcept {
  const bool both = format.views != FrameViews::one;
  const auto* bytes = reinterpret_cast<const uint8_t*>(frame.bytes);
  ptrdiff_t stride = format.stride;
  for (const GrayView& view : views)
    if (view.width != format.width || view.height != format.height) {
      problem_ = "a view of " + std::to_string(format.width) + "x" + std::to_string(format.height) + ", needed is " +
                 std::to_string(view.width) + "x" + std::to_string(view.height);
      return false;
    }
  if (format.pixels == FramePixels::jpeg) {
    if (!unpack_jpeg(format, frame)) return false;
    bytes = jpeg_->gray.data();
    stride = format.width * (both ? 2 : 1);
  } else if (const auto row = static_cast<ptrdiff_t>(format.width) * raw_pixel_bytes(format);
             frame.size < static_cast<size_t>(stride * (format.height - 1) + row)) {
    problem_ = "a frame of " + std::to_string(frame.size) + " bytes, needed are " + std::to_string(stride * (format.height - 1) + row);
    return false;
  }
  const int pixel = bytes_of(format.pixels);
  for (size_t i = 0; i < views.size(); ++i) {
    const GrayView& view = views[i];
    const ptrdiff_t number = exchanged && views.size() == 2 ? 1 - static_cast<ptrdiff_t>(i) : static_cast<ptrdiff_t>(i);
    const ptrdiff_t start = format.views == FrameViews::by_turns ? number * pixel : number * pixel * format.width;
    const int step = format.views == FrameViews::by_turns ? 2 * pixel : pixel;
    for (int y = 0; y < view.height; ++y)
      write_row(format.pixels, bytes + y * stride + start, step, view.width, view.pixels + y * view.stride);
  }
  return true;
}

}  // namespace vdisp
