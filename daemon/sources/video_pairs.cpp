// video_pairs.cpp: reads two videos in step, or one with both views side by side.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <opencv2/imgproc.hpp>

#include "daemon/sources/pair_readers.h"
#include "daemon/sources/source.h"

namespace vdisp {
namespace {

// Tried in a row before a video counts as ended: OpenCV does not tell its end from damage in it.
constexpr int most_failures = 100;

void to_gray(const cv::Mat& frame, cv::Mat& gray) {
  if (frame.channels() == 1)
    frame.copyTo(gray);
  else
    cv::cvtColor(frame, gray, cv::COLOR_BGR2GRAY);
}

}  // namespace

VideoPairs::VideoPairs(std::string left, std::string right) : views_(right.empty() ? 1 : 2) {
  videos_[0].file = std::move(left);
  videos_[1].file = std::move(right);
  open();
  for (int i = 0; i < views_; ++i)
    if (!read(videos_[i])) throw SourceError(66, "[image source] " + videos_[i].file + ": a video without a first frame");
  size_ = videos_[0].frame.size();
  if (views_ == 1 && size_.width % 2 != 0)
    throw SourceError(
        78, "[image source] left = " + videos_[0].file + " is " + size_text(size_) + "; two views side by side need an even width");
  if (views_ == 2 && videos_[1].frame.size() != size_)
    throw SourceError(78, "[image source] left = " + videos_[0].file + " is " + size_text(size_) + ", right = " + videos_[1].file + " is " +
                              size_text(videos_[1].frame.size()) + "; needed is one size");
}

void VideoPairs::open() {
  setenv("OPENCV_FFMPEG_LOGLEVEL", "-8", 0);  // what is wrong with a frame is told by problem(), once
  for (int i = 0; i < views_; ++i) {
    Video& video = videos_[i];
    // FFmpeg alone: others take the name apart for patterns of their own.
    if (!video.capture.open(video.file, cv::CAP_FFMPEG))
      throw SourceError(66, "[image source] " + std::string(i == 0 ? "left" : "right") + " = " + video.file +
                                ": neither an image nor a video that can be read (damaged or truncated?)");
    video.number = video.dated = -1;
    video.damaged = false;
  }
  next_ = 0;
  rate_ = videos_[0].capture.get(cv::CAP_PROP_FPS);
  if (!(rate_ >= 0.01 && rate_ <= 1000)) rate_ = 0;
}

/// The next frame that can be decoded, and its number. False: none follows.
bool VideoPairs::read(Video& video) const {
  int failures = 0;
  while (!video.capture.read(video.frame))
    if (++failures > most_failures) return false;
  video.damaged = video.damaged || failures > 0;
  video.number += 1 + (video.dated < 0 ? failures : 0);
  const double now_ms = video.capture.get(cv::CAP_PROP_POS_MSEC);
  if (!(now_ms > 0)) return true;
  // Decoders delay and reorder frames: how many were lost, and where, is told by the times alone. In a video without damage
  // every frame follows the one before it, whatever the times.
  if (video.damaged && video.dated >= 0 && rate_ > 0)
    video.number = std::max<int64_t>(video.number, video.dated + std::llround((now_ms - video.dated_ms) * rate_ / 1000));
  video.dated = video.number;
  video.dated_ms = now_ms;
  return true;
}

void VideoPairs::explain_end(int ended) {
  const double promised = videos_[ended].capture.get(cv::CAP_PROP_FRAME_COUNT);
  const bool fewer = promised > static_cast<double>(next_) + 1;
  bool before_other = false;
  if (views_ == 2) {
    Video& other = videos_[1 - ended];
    before_other = other.number >= next_ || read(other);
  }
  if (fewer || before_other)
    problem_ = videos_[ended].file + " ends after " + std::to_string(next_) + " frames" + (fewer ? ", fewer than its header says" : "") +
               (before_other ? ", before the other view" : "");
}

PairRead VideoPairs::next() {
  problem_.clear();
  for (int i = 0; i < views_; ++i) {
    if (videos_[i].number >= next_ || read(videos_[i])) continue;
    explain_end(i);
    return PairRead::end;
  }
  const int64_t number = next_++;
  for (int i = 0; i < views_; ++i) {
    const Video& video = videos_[i];
    if (video.number != number)
      problem_ = video.file + ": frame " + std::to_string(number) + " is damaged or missing";
    else if (video.frame.size() != size_)
      problem_ =
          video.file + ": frame " + std::to_string(number) + " is " + size_text(video.frame.size()) + ", the first was " + size_text(size_);
    if (!problem_.empty()) return PairRead::bad;
  }
  const int half = size_.width / 2;
  if (views_ == 1) {
    to_gray(videos_[0].frame(cv::Rect(0, 0, half, size_.height)), gray_[0]);
    to_gray(videos_[0].frame(cv::Rect(half, 0, half, size_.height)), gray_[1]);
  } else {
    for (int i : {0, 1}) to_gray(videos_[i].frame, gray_[i]);
  }
  return PairRead::good;
}

void VideoPairs::rewind() {
  if (next_ > 0) open();
}

std::pair<std::string, std::string> VideoPairs::names() const {
  if (next_ == 0) return {};
  const std::string frame = std::string("#").append(std::to_string(next_ - 1));
  return {videos_[0].file + frame, videos_[views_ - 1].file + frame};
}

}  // namespace vdisp
