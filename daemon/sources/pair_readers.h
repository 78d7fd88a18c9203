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

inline std::string size_text(const cv::Size& size) { return std::to_string(size.width) + "x" + std::to_string(size.height); }

/// bad: this pair is missing, damaged or of two sizes; the next one may be good.
enum class PairRead { good, bad, end };

/// 8-bit gray. After next(): both views where it was good, else problem() in one line.
class ImagePairs {
 public:
  explicit ImagePairs(std::vector<PairName> pairs) : pairs_(std::move(pairs)) {}
  /// Looks at the first `most` good pairs, once, before the first next(): gives their sizes, and decides for the whole recording
  /// what white is in 16-bit files: 1023 or 4095 where nothing is brighter, as cameras of 10 and 12 bit write them, else 65535.
  /// Empty: no pair is good, and problem() tells of the first.
  std::vector<cv::Size> survey(size_t most);
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
  double white_ = 65535;  ///< of 16-bit files
  std::string problem_;
};

/// Two videos, or one with both views side by side where `right` is empty. It ends with the shorter one. A frame that cannot be
/// decoded makes a bad pair, and the views stay in step.
class VideoPairs {
 public:
  /// Throws SourceError: 66 cannot be opened, 78 views of two sizes or of odd width.
  VideoPairs(std::string left, std::string right);
  /// At an end before the one that the header promises, problem() says so.
  PairRead next();
  void rewind();

  const cv::Mat& left() const { return gray_[0]; }
  const cv::Mat& right() const { return gray_[1]; }
  const std::string& problem() const { return problem_; }
  std::pair<std::string, std::string> names() const;
  double rate() const { return rate_; }
  cv::Size view_size() const { return {views_ == 1 ? size_.width / 2 : size_.width, size_.height}; }
  int64_t recorded_ns() const { return -1; }
  int64_t recorded_span_ns() const { return 0; }

 private:
  struct Video {
    std::string file;
    cv::VideoCapture capture;
    cv::Mat frame;
    int64_t number = -1;  ///< of `frame`
    int64_t dated = -1;   ///< the last frame that told its time
    double dated_ms = 0;
    bool damaged = false;
  };

  void open();
  bool read(Video& video) const;
  void explain_end(int ended);

  Video videos_[2];
  int views_;  ///< videos there are
  cv::Mat gray_[2];
  cv::Size size_;  ///< of a frame as it is in the file
  int64_t next_ = 0;
  double rate_ = 0;
  std::string problem_;
};

}  // namespace vdisp
