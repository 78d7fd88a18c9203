// processor.h: what a stage of the tree is: the paper's ImageProcessor and its three kinds (paper 3.1).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "ipc/image.h"

namespace vdisp {

/// valid: the outputs hold a result; a stage that cannot vouch for one of several sets that one blind itself. invalid: none does,
/// the reason is in the first. end: the source has no more frames.
enum class Outcome { valid, invalid, end };

/// Thrown by check(): says what was found and what was needed. The driver adds the names of both ends.
class FormatError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Owns arithmetic; the driver owns memory and order. check() runs once, while the tree is built, and may throw;
/// process() runs for every frame and neither throws, allocates, locks nor waits without limit.
class ImageProcessor {
 public:
  virtual ~ImageProcessor() = default;
  ImageProcessor() = default;
  ImageProcessor(const ImageProcessor&) = delete;
  ImageProcessor& operator=(const ImageProcessor&) = delete;

  /// The formats it will write for inputs of these formats. Throws FormatError.
  virtual std::vector<ImageSpec> check(std::span<const ImageSpec> in) = 0;
  /// Inputs are valid images of one frame; delayed ones (Driver::last) may be blind, and are older; those given as even_blind() may be
  /// blind. Outputs have the header of the first input (frame, time, flags, geometry) already.
  virtual Outcome process(std::span<const Image* const> in, std::span<Image* const> out) noexcept = 0;
  /// Between two frames: forgets all that earlier frames left, so that from here on it makes what it would have made from a start.
  /// A stage that keeps nothing from frame to frame needs none.
  virtual void begin_anew() noexcept {}
};

/// No input of this frame; a set of images per frame. Sets timestamp, flags, geometry and calibration hash of what it grabs.
class ImageSource : public ImageProcessor {
 public:
  virtual std::vector<ImageSpec> open() = 0;
  /// Waits at most 100 ms. invalid: no pair this time, with the reason in out[0].
  virtual Outcome grab(std::span<Image* const> out) noexcept = 0;
  /// What it wants to know of the last frame, each an input made by Driver::last(): a world that moves as the tree says. None for most.
  virtual std::vector<ImageSpec> heeds() const { return {}; }
  /// Called before each grab() of a source that heeds anything. They may be blind, and are where nothing was made yet.
  virtual void heed(std::span<const Image* const>) noexcept {}

  std::vector<ImageSpec> check(std::span<const ImageSpec> in) final {
    const std::vector<ImageSpec> wanted = heeds();
    if (in.size() != wanted.size())
      throw FormatError("takes " + (wanted.empty() ? "no input" : std::to_string(wanted.size()) + " of the last frame") + ", was given " +
                        std::to_string(in.size()));
    for (size_t i = 0; i < in.size(); ++i)
      if (in[i] != wanted[i]) throw FormatError("what it is told of the last frame is not what it heeds");
    return open();
  }
  Outcome process(std::span<const Image* const> in, std::span<Image* const> out) noexcept final {
    if (!in.empty()) heed(in);
    return grab(out);
  }
};

/// As many images out as in, each from its own input.
class ImageFilter : public ImageProcessor {
 public:
  virtual ImageSpec accept(const ImageSpec& in) = 0;
  /// False: no result, the reason is in out.
  virtual bool filter(const Image& in, Image& out) noexcept = 0;

  std::vector<ImageSpec> check(std::span<const ImageSpec> in) final {
    if (in.empty()) throw FormatError("takes one image or more, was given none");
    std::vector<ImageSpec> out;
    for (const ImageSpec& spec : in) out.push_back(accept(spec));
    return out;
  }
  Outcome process(std::span<const Image* const> in, std::span<Image* const> out) noexcept final {
    bool valid = true;
    for (size_t i = 0; i < in.size(); ++i) {
      if (!filter(*in[i], *out[i])) valid = false;
    }
    return valid ? Outcome::valid : Outcome::invalid;
  }
};

/// One image from two.
class BinaryOperator : public ImageProcessor {
 public:
  virtual ImageSpec accept(const ImageSpec& a, const ImageSpec& b) = 0;
  /// False: no result, the reason is in out.
  virtual bool combine(const Image& a, const Image& b, Image& out) noexcept = 0;

  std::vector<ImageSpec> check(std::span<const ImageSpec> in) final {
    if (in.size() != 2) throw FormatError("takes two images, was given " + std::to_string(in.size()));
    return {accept(in[0], in[1])};
  }
  Outcome process(std::span<const Image* const> in, std::span<Image* const> out) noexcept final {
    return combine(*in[0], *in[1], *out[0]) ? Outcome::valid : Outcome::invalid;
  }
};

/// Throws FormatError unless `found`, the input called `which`, is of this kind.
inline void require(const ImageSpec& found, Pixel needed, const std::string& which) {
  if (found.pixel != needed)
    throw FormatError(which + " is " + std::string(name(found.pixel)) + ", needed is " + std::string(name(needed)));
}

/// Throws FormatError unless two inputs are of one size.
inline void require_same_size(const ImageSpec& a, const ImageSpec& b) {
  if (a.width != b.width || a.height != b.height)
    throw FormatError("the inputs are " + std::to_string(a.width) + "x" + std::to_string(a.height) + " and " + std::to_string(b.width) +
                      "x" + std::to_string(b.height) + ", needed is one size");
}

}  // namespace vdisp
