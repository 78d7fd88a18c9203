// files.cpp: the source `files`: reads pairs in lock-step with the tree, no thread, stamped with the time of the recording.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sources/files.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <exception>
#include <filesystem>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>
#include <variant>

#include "daemon/sources/pair_readers.h"
#include "daemon/sources/recorded_odometry.h"
#include "daemon/sources/replay.h"

namespace vdisp {
namespace {

constexpr double default_rate = 30;  // Hz, of timestamps where nothing tells the rate
constexpr int largest = 8192;        // px, as [image source] width
constexpr size_t surveyed = 10;      // good pairs that tell the size

class FilesSource final : public StereoSource {
 public:
  explicit FilesSource(const Config& config) : settings_(config.image_source), mounting_(config.mounting) {
    if (!settings_.paramfile.empty()) calibration_ = read_calibration(settings_.paramfile);
    if (!settings_.odometry.empty()) way_.emplace(settings_.odometry);
  }

  std::vector<ImageSpec> open() override;
  Outcome grab(std::span<Image* const> out) noexcept override;
  std::optional<Calibration> calibration() const override { return calibration_; }
  int64_t period_ns() const override { return settings_.rate > 0 ? std::llround(1e9 / settings_.rate) : 0; }
  std::pair<std::string, std::string> files() const override {
    return std::visit([](const auto& pairs) { return pairs.names(); }, pairs_);
  }
  std::string_view fault() const noexcept override { return fault_; }
  const Odometry* odometry() const noexcept override { return way_ ? &pose_ : nullptr; }

 private:
  using Pairs = std::variant<ImagePairs, VideoPairs>;

  Pairs open_pairs() const;
  cv::Size first_size();
  cv::Size wanted_size() const;
  void check_size(const cv::Size& size) const;
  PairRead next();
  void rewind();
  bool fill(std::span<Image* const> out) noexcept;
  std::string wrong_size() const;
  int64_t timestamp_ns() const;

  const image_source_section settings_;
  const mounting_section& mounting_;  // live
  std::optional<Calibration> calibration_;
  Pairs pairs_{ImagePairs({})};
  ImageSpec spec_;
  double rate_ = default_rate;
  int64_t taken_ = 0;  ///< pairs since the start
  int64_t loops_ = 0;
  std::optional<RecordedOdometry> way_;
  Odometry pose_{};     ///< of the last pair
  int64_t number_ = 0;  ///< of the next pair in the recording
  std::string fault_;
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
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);  // what is wrong with a pair is told by fault()
  pairs_ = open_pairs();
  const double recorded = std::visit([](const auto& pairs) { return pairs.rate(); }, pairs_);
  rate_ = settings_.rate > 0 ? settings_.rate : recorded > 0 ? recorded : default_rate;
  const cv::Size size = first_size();
  check_size(size);
  spec_ = {Pixel::gray8, 0, static_cast<uint16_t>(size.width), static_cast<uint16_t>(size.height)};
  return {spec_, spec_};
}

/// Most of the first good pairs tell the size, and of those that fit the configuration, where some do: a stray picture is a bad
/// pair. Bad ones before them stay in the sequence.
cv::Size FilesSource::first_size() {
  if (const auto* videos = std::get_if<VideoPairs>(&pairs_)) return videos->view_size();
  ImagePairs& images = std::get<ImagePairs>(pairs_);
  const std::vector<cv::Size> sizes = images.survey(surveyed);
  if (sizes.empty())
    throw SourceError(66, "[image source] none of " + std::to_string(images.count()) + " pairs is good: " + images.problem());
  const cv::Size wanted = wanted_size();
  const auto weight = [&](const cv::Size& size) {
    const bool fits = (wanted.width == 0 || size.width == wanted.width) && (wanted.height == 0 || size.height == wanted.height);
    return std::pair(fits, std::count(sizes.begin(), sizes.end(), size));
  };
  return *std::max_element(sizes.begin(), sizes.end(), [&](const cv::Size& a, const cv::Size& b) { return weight(a) < weight(b); });
}

/// What the calibration, width and height ask for; 0: nothing does.
cv::Size FilesSource::wanted_size() const {
  if (calibration_ && calibration_->width != 0) return {calibration_->width, calibration_->height};
  return {settings_.width, settings_.height};
}

void FilesSource::check_size(const cv::Size& size) const {
  const std::string found = "[image source] left = " + settings_.left + ": images are " + size_text(size);
  if (size.width > largest || size.height > largest)
    throw SourceError(78, found + ", at most " + size_text({largest, largest}) + " can be");
  const cv::Size wanted{settings_.width != 0 ? settings_.width : size.width, settings_.height != 0 ? settings_.height : size.height};
  if (wanted != size) throw SourceError(78, found + ", needed by width and height is " + size_text(wanted));
  if (calibration_ && calibration_->width != 0 && cv::Size(calibration_->width, calibration_->height) != size)
    throw SourceError(
        78, found + ", the calibration " + settings_.paramfile + " is for " + size_text({calibration_->width, calibration_->height}));
}

PairRead FilesSource::next() {
  return std::visit([](auto& pairs) { return pairs.next(); }, pairs_);
}

void FilesSource::rewind() {
  std::visit([](auto& pairs) { pairs.rewind(); }, pairs_);
  ++loops_;
  number_ = 0;
}

int64_t FilesSource::timestamp_ns() const {
  if (const auto* images = std::get_if<ImagePairs>(&pairs_); images && images->recorded_ns() >= 0)
    return images->recorded_ns() + loops_ * images->recorded_span_ns();
  return std::llround(static_cast<double>(taken_) * 1e9 / rate_);
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

std::string FilesSource::wrong_size() const {
  const cv::Size found = std::visit([](const auto& pairs) { return pairs.left().size(); }, pairs_);
  return files().first + " is " + size_text(found) + ", not " + size_text({spec_.width, spec_.height}) + " as the others";
}

Outcome FilesSource::grab(std::span<Image* const> out) noexcept {
  fault_.clear();
  PairRead read = PairRead::bad;
  try {
    read = next();
    if (read == PairRead::end && settings_.loop && taken_ > 0) {
      rewind();
      read = next();
    }
    if (read != PairRead::good) fault_ = std::visit([](const auto& pairs) { return pairs.problem(); }, pairs_);
  } catch (const std::exception& e) {
    fault_ = std::string("reading ends: ") + e.what();
    return Outcome::end;
  }
  if (read == PairRead::end) return Outcome::end;
  const bool good = read == PairRead::good && fill(out);
  if (read == PairRead::good && !good) fault_ = wrong_size();
  for (Image* image : out) {
    image->timestamp_ns = timestamp_ns();
    image->flags |= flag_synthetic;
    image->calibration_hash = calibration_ ? calibration_->hash : 0;
    if (good) continue;
    image->set_blind(Reason::bad_pair);
    for (int y = 0; y < spec_.height; ++y) std::memset(image->row<uint8_t>(y), 0, spec_.width);
  }
  if (way_) {
    pose_ = way_->at(number_, timestamp_ns(), mounting_);
    pose_.timestamp_ns = out[0]->timestamp_ns;
    pose_.frame = static_cast<uint32_t>(loops_);  // the recording begins anew, and so does its odometry
  }
  ++taken_;
  ++number_;
  return good ? Outcome::valid : Outcome::invalid;
}

}  // namespace

std::unique_ptr<StereoSource> open_files(const Config& config) {
  if (!config.image_source.recording.empty()) return open_replay(config);
  return std::make_unique<FilesSource>(config);
}

}  // namespace vdisp
