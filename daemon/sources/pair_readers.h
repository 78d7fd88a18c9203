// pair_readers.h: recorded stereo pairs as gray images, one after the other: from image files and from videos.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>
#include <string>
#include <utility>
#include <vector>

#include "daemon/sources/pair_names.h"

namespace vdisp {

/// bad: this pair is missing, damaged or of two sizes; the next one may be good.
enum class PairRead { good, bad, end };

/// 8-bit gray. After next(): both views where it was good, else problem() in one line.
class ImagePairs {
 public:
  explicit ImagePairs(std::vector<PairName> pairs) : pairs_(std::move(pairs)) {}
  PairRead next();
  void rewind() { next_ = 0; }

  const cv::Mat& left() const { return gray_[0]; }
  const cv::Mat& right() const { return gray_[1]; }
  const std::string& problem() const { return problem_; }
  std::pair<std::string, std::string> names() const;
  size_t count() const { return pairs_.size(); }
  /// Frames per second of the recording; 0: it does not tell.
  double rate() const { return 0; }
  /// When the last pair was recorded; -1: it does not tell.
  int64_t recorded_ns() const { return pairs_[next_ - 1].recorded_ns; }
  /// How long the recording lasts, the last frame included; 0: it does not tell.
  int64_t recorded_span_ns() const;

 private:
  bool read(const std::string& file, cv::Mat& decoded, cv::Mat& gray);

  std::vector<PairName> pairs_;
  size_t next_ = 0;
  std::vector<uint8_t> bytes_;
  cv::Mat decoded_[2], gray_[2];
  std::string problem_;
};

/// Two videos, or one with both views side by side where `right` is empty. It ends with the shorter one.
class VideoPairs {
 public:
  /// Throws SourceError: 66 cannot be opened, 78 views of two sizes or of odd width.
  VideoPairs(std::string left, std::string right);
  PairRead next();
  void rewind();

  const cv::Mat& left() const { return gray_[0]; }
  const cv::Mat& right() const { return gray_[1]; }
  const std::string& problem() const { return problem_; }
  std::pair<std::string, std::string> names() const;
  size_t count() const { return next_; }
  double rate() const { return rate_; }
  cv::Size view_size() const { return {files_[1].empty() ? size_.width / 2 : size_.width, size_.height}; }
  int64_t recorded_ns() const { return -1; }
  int64_t recorded_span_ns() const { return 0; }

 private:
  void open();
  bool read();
  void warn_of_end(bool left_ended, bool right_ended);

  std::string files_[2];
  cv::VideoCapture videos_[2];
  cv::Mat colour_[2], gray_[2];
  cv::Size size_;  ///< of a frame as it is in the file
  bool pending_ = false, warned_ = false;
  size_t next_ = 0;
  double rate_ = 0;
  std::string problem_;
};

}  // namespace vdisp
