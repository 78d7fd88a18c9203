// video_pairs.cpp: reads two videos in step, or one with both views side by side.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <opencv2/imgproc.hpp>

#include "daemon/sources/pair_readers.h"
#include "daemon/sources/source.h"

namespace vdisp {
namespace {

std::string size_text(const cv::Size& size) { return std::to_string(size.width) + "x" + std::to_string(size.height); }

void to_gray(const cv::Mat& frame, cv::Mat& gray) {
  if (frame.channels() == 1)
    frame.copyTo(gray);
  else
    cv::cvtColor(frame, gray, cv::COLOR_BGR2GRAY);
}

}  // namespace

VideoPairs::VideoPairs(std::string left, std::string right) : files_{std::move(left), std::move(right)} {
  open();
  if (!read())
    throw SourceError(66,
                      "[image source] " + files_[0] + (files_[1].empty() ? "" : " or " + files_[1]) + ": a video without a first frame");
  size_ = colour_[0].size();
  if (files_[1].empty() && size_.width % 2 != 0)
    throw SourceError(78, "[image source] left = " + files_[0] + " is " + size_text(size_) + "; two views side by side need an even width");
  if (!files_[1].empty() && colour_[1].size() != size_)
    throw SourceError(78, "[image source] left = " + files_[0] + " is " + size_text(size_) + ", right = " + files_[1] + " is " +
                              size_text(colour_[1].size()) + "; needed is one size");
  pending_ = true;
}

void VideoPairs::open() {
  for (int i = 0; i < (files_[1].empty() ? 1 : 2); ++i) {
    // FFmpeg alone: others take the name apart for patterns of their own.
    if (!videos_[i].open(files_[i], cv::CAP_FFMPEG))
      throw SourceError(66, "[image source] " + std::string(i == 0 ? "left" : "right") + " = " + files_[i] +
                                ": neither an image nor a video that can be read (damaged or truncated?)");
  }
  rate_ = videos_[0].get(cv::CAP_PROP_FPS);
  if (!(rate_ >= 0.01 && rate_ <= 1000)) rate_ = 0;
}

bool VideoPairs::read() {
  const bool left = videos_[0].read(colour_[0]), right = files_[1].empty() || videos_[1].read(colour_[1]);
  if (left && right) return true;
  warn_of_end(!left, !right);
  return false;
}

/// OpenCV cannot tell the end of a video from damage in it: the number of frames that its header promises can.
void VideoPairs::warn_of_end(bool left_ended, bool right_ended) {
  if (warned_ || next_ == 0) return;
  const int ended = left_ended ? 0 : 1;
  const double promised = videos_[ended].get(cv::CAP_PROP_FRAME_COUNT);
  const bool one_ended = !files_[1].empty() && left_ended != right_ended;
  if (!one_ended && !(promised > static_cast<double>(next_) + 1)) return;
  warned_ = true;
  std::fprintf(stderr, "files: %s ends after %zu frames%s%s\n", files_[ended].c_str(), next_,
               promised > static_cast<double>(next_) + 1 ? ", fewer than its header says" : "", one_ended ? ", before the other view" : "");
}

PairRead VideoPairs::next() {
  if (!pending_ && !read()) return PairRead::end;
  pending_ = false;
  ++next_;
  if (colour_[0].size() != size_ || (!files_[1].empty() && colour_[1].size() != size_)) {
    problem_ = names().first + ": the size changes within the video, it was " + size_text(size_);
    return PairRead::bad;
  }
  const int half = size_.width / 2;
  if (files_[1].empty()) {
    to_gray(colour_[0](cv::Rect(0, 0, half, size_.height)), gray_[0]);
    to_gray(colour_[0](cv::Rect(half, 0, half, size_.height)), gray_[1]);
  } else {
    for (int i : {0, 1}) to_gray(colour_[i], gray_[i]);
  }
  return PairRead::good;
}

void VideoPairs::rewind() {
  if (pending_) return;  // nothing was taken from it yet
  open();
  next_ = 0;
}

std::pair<std::string, std::string> VideoPairs::names() const {
  if (next_ == 0) return {};
  const std::string frame = std::string("#").append(std::to_string(next_ - 1));
  return {files_[0] + frame, (files_[1].empty() ? files_[0] : files_[1]) + frame};
}

}  // namespace vdisp
