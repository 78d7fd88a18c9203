// files.cpp: the source `files`: reads pairs in lock-step with the tree, no thread, stamped with the time of the recording.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sources/files.h"

#include <cmath>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>
#include <variant>

#include "daemon/core/clock.h"
#include "daemon/sources/pair_readers.h"

namespace vdisp {
namespace {

constexpr double default_rate = 30;  // Hz, of timestamps where nothing tells the rate
constexpr int largest = 8192;        // px, as [image source] width

std::string size_text(int width, int height) { return std::to_string(width) + "x" + std::to_string(height); }

class FilesSource final : public StereoSource {
 public:
  explicit FilesSource(const Config& config) : settings_(config.image_source) {
    if (!settings_.paramfile.empty()) calibration_ = read_calibration(settings_.paramfile);
  }

  std::vector<ImageSpec> open() override;
  Outcome grab(std::span<Image* const> out) noexcept override;
  std::optional<Calibration> calibration() const override { return calibration_; }
  int64_t period_ns() const override { return settings_.rate > 0 ? std::llround(1e9 / settings_.rate) : 0; }
  std::pair<std::string, std::string> files() const override {
    return std::visit([](const auto& pairs) { return pairs.names(); }, pairs_);
  }

 private:
  using Pairs = std::variant<ImagePairs, VideoPairs>;

  Pairs open_pairs() const;
  cv::Size first_size();
  void check_size(const cv::Size& size) const;
  PairRead next();
  void rewind();
  bool fill(std::span<Image* const> out) noexcept;
  int64_t timestamp_ns() const;
  CameraGeometry geometry() const;
  void report(bool good, const char* problem) noexcept;

  const image_source_section settings_;
  std::optional<Calibration> calibration_;
  Pairs pairs_{ImagePairs({})};
  ImageSpec spec_;
  double rate_ = default_rate;
  int64_t taken_ = 0;  ///< pairs since the start
  int64_t loops_ = 0;
  bool bad_ = false;
  int64_t told_ns_ = INT64_MIN / 2;
};

FilesSource::Pairs FilesSource::open_pairs() const {
  const std::string &left = settings_.left, &right = settings_.right;
  if (left.empty())
    throw SourceError(78, "[image source] left is empty; source = files needs images (left/%06d.png, left/*.png) or a video");
  const NameForm form = form_of(left);
  for (const std::string* name : {&left, &right}) {
    if (std::error_code error; !name->empty() && std::filesystem::is_directory(*name, error))
      throw SourceError(
          78, "[image source] " + *name + " is a folder; needed are its images: " + (std::filesystem::path(*name) / "*.png").string());
  }
  if (!right.empty() && form_of(right) != form)
    throw SourceError(78, "[image source] left = " + left + " is " + describe(form) + ", right = " + right + " is " +
                              describe(form_of(right)) + "; needed are two of a kind");
  if (form != NameForm::literal) {
    if (right.empty())
      throw SourceError(78, "[image source] right is empty; only a video may hold both views, " + left + " is " + describe(form));
    return ImagePairs(list_pairs(left, right));
  }
  for (const std::string* name : {&left, &right}) {
    if (std::error_code error; !name->empty() && !std::filesystem::exists(*name, error))
      throw SourceError(66, "[image source] " + *name + ": no such file; needed is an image, a video, a pattern (%06d) or a glob (*)");
  }
  if (!cv::haveImageReader(left)) return VideoPairs(left, right);
  if (right.empty()) throw SourceError(78, "[image source] right is empty; only a video may hold both views, " + left + " is an image");
  return ImagePairs(list_pairs(left, right));
}

std::vector<ImageSpec> FilesSource::open() {
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);  // a bad pair is reported once, here
  pairs_ = open_pairs();
  const double recorded = std::visit([](const auto& pairs) { return pairs.rate(); }, pairs_);
  rate_ = settings_.rate > 0 ? settings_.rate : recorded > 0 ? recorded : default_rate;
  const cv::Size size = first_size();
  check_size(size);
  spec_ = {Pixel::gray8, 0, static_cast<uint16_t>(size.width), static_cast<uint16_t>(size.height)};
  return {spec_, spec_};
}

/// The first good pair tells the size; bad ones before it stay in the sequence.
cv::Size FilesSource::first_size() {
  if (const auto* videos = std::get_if<VideoPairs>(&pairs_)) return videos->view_size();
  ImagePairs& images = std::get<ImagePairs>(pairs_);
  std::string first_problem;
  PairRead result;
  while ((result = images.next()) == PairRead::bad)
    if (first_problem.empty()) first_problem = images.problem();
  if (result == PairRead::end)
    throw SourceError(66, "[image source] none of " + std::to_string(images.count()) + " pairs is good: " + first_problem);
  const cv::Size size = images.left().size();
  images.rewind();
  return size;
}

void FilesSource::check_size(const cv::Size& size) const {
  const std::string found = size_text(size.width, size.height);
  if (size.width > largest || size.height > largest)
    throw SourceError(
        78, "[image source] left = " + settings_.left + ": images are " + found + ", at most " + size_text(largest, largest) + " can be");
  if ((settings_.width != 0 && settings_.width != size.width) || (settings_.height != 0 && settings_.height != size.height))
    throw SourceError(
        78, "[image source] left = " + settings_.left + ": images are " + found + ", needed by width and height is " +
                size_text(settings_.width != 0 ? settings_.width : size.width, settings_.height != 0 ? settings_.height : size.height));
  if (calibration_ && calibration_->width != 0 && (calibration_->width != size.width || calibration_->height != size.height))
    throw SourceError(78, "[image source] left = " + settings_.left + ": images are " + found + ", the calibration " + settings_.paramfile +
                              " is for " + size_text(calibration_->width, calibration_->height));
}

PairRead FilesSource::next() {
  return std::visit([](auto& pairs) { return pairs.next(); }, pairs_);
}

void FilesSource::rewind() {
  std::visit([](auto& pairs) { pairs.rewind(); }, pairs_);
  ++loops_;
}

int64_t FilesSource::timestamp_ns() const {
  if (const auto* images = std::get_if<ImagePairs>(&pairs_); images && images->recorded_ns() >= 0)
    return images->recorded_ns() + loops_ * images->recorded_span_ns();
  return std::llround(static_cast<double>(taken_) * 1e9 / rate_);
}

/// Of the rectified view, which is what follows from these images.
CameraGeometry FilesSource::geometry() const {
  CameraGeometry camera{};
  camera.min_disparity = settings_.minDisparity;
  camera.disparities = settings_.ndisp;
  if (!calibration_) return camera;
  const StereoView& view = calibration_->view;
  camera.f = static_cast<float>(view.f);
  camera.cx = static_cast<float>(view.cx);
  camera.cy = static_cast<float>(view.cy);
  camera.baseline = static_cast<float>(view.baseline);
  camera.cx_offset = static_cast<float>(view.cx_offset);
  return camera;
}

bool FilesSource::fill(std::span<Image* const> out) noexcept {
  return std::visit(
      [&](const auto& pairs) {
        const cv::Mat* views[] = {&pairs.left(), &pairs.right()};
        for (const cv::Mat* view : views)
          if (view->cols != spec_.width || view->rows != spec_.height) return false;
        for (int i : {0, 1})
          for (int y = 0; y < spec_.height; ++y) std::memcpy(out[i]->row<uint8_t>(y), views[i]->ptr(y), spec_.width);
        return true;
      },
      pairs_);
}

/// One line when pairs begin to be bad, at most one a second; counters tell the rest.
void FilesSource::report(bool good, const char* problem) noexcept {
  const int64_t now = monotonic_ns();
  if (!good && !bad_ && now - told_ns_ >= 1'000'000'000) {
    std::fprintf(stderr, "files: pair %lld is bad: %s\n", static_cast<long long>(taken_), problem);
    told_ns_ = now;
  }
  bad_ = !good;
}

Outcome FilesSource::grab(std::span<Image* const> out) noexcept {
  PairRead read = PairRead::bad;
  std::string problem;
  try {
    read = next();
    if (read == PairRead::end && settings_.loop && taken_ > 0) {
      rewind();
      read = next();
    }
    if (read == PairRead::bad) problem = std::visit([](const auto& pairs) { return pairs.problem(); }, pairs_);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "files: reading ends: %s\n", e.what());
    return Outcome::end;
  }
  if (read == PairRead::end) return Outcome::end;
  const bool good = read == PairRead::good && fill(out);
  if (read == PairRead::good && !good) problem = "another size than " + size_text(spec_.width, spec_.height) + ", that of the first pair";
  report(good, problem.c_str());
  for (Image* image : out) {
    image->timestamp_ns = timestamp_ns();
    image->flags |= flag_synthetic;
    image->camera = geometry();
    image->calibration_hash = calibration_ ? calibration_->hash : 0;
    if (good) continue;
    image->set_blind(Reason::bad_pair);
    for (int y = 0; y < spec_.height; ++y) std::memset(image->row<uint8_t>(y), 0, spec_.width);
  }
  ++taken_;
  return good ? Outcome::valid : Outcome::invalid;
}

}  // namespace

std::unique_ptr<StereoSource> open_files(const Config& config) { return std::make_unique<FilesSource>(config); }

}  // namespace vdisp
