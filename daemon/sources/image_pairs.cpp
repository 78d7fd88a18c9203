// image_pairs.cpp: reads image files, and tells whole ones from truncated ones.
// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <span>
#include <string_view>
#include <system_error>

#include "daemon/sources/pair_readers.h"

namespace vdisp {
namespace {

constexpr off_t largest = off_t{1} << 28;  // bytes of a file

using Bytes = std::span<const uint8_t>;

bool begins(Bytes bytes, std::string_view head) {
  return bytes.size() >= head.size() &&
         std::equal(head.begin(), head.end(), bytes.begin(), [](char a, uint8_t b) { return static_cast<uint8_t>(a) == b; });
}

/// Decoders make a picture of half a file, gray where it ends: look for the end first. Walks the chunks up to IEND.
bool png_is_whole(Bytes png) {
  for (size_t at = 8; at + 12 <= png.size();) {
    const uint64_t length = uint64_t{png[at]} << 24 | png[at + 1] << 16 | png[at + 2] << 8 | png[at + 3];
    const uint64_t end = at + 12 + length;
    if (end > png.size()) return false;
    if (begins(png.subspan(at + 4), "IEND")) return true;
    at = end;
  }
  return false;
}

/// Walks the segments to the first scan (a thumbnail before it has an end marker too), then looks for the end marker.
bool jpeg_is_whole(Bytes jpeg) {
  size_t at = 2;
  while (at + 4 <= jpeg.size() && jpeg[at] == 0xff && jpeg[at + 1] != 0xda) {
    if (jpeg[at + 1] == 0xff)
      ++at;  // fill byte
    else
      at += 2 + (size_t{jpeg[at + 2]} << 8 | jpeg[at + 3]);
  }
  if (at + 4 > jpeg.size() || jpeg[at] != 0xff) return false;
  for (; at + 1 < jpeg.size(); ++at)
    if (jpeg[at] == 0xff && jpeg[at + 1] == 0xd9) return true;
  return false;
}

/// PGM or PPM in binary: the header tells how much follows. (OpenCV would refuse it too, but with lines of its own on stderr.)
bool pnm_is_whole(Bytes pnm) {
  uint64_t header[3] = {0, 0, 0};  // width, height, greatest value
  size_t at = 2;
  for (uint64_t& number : header) {
    while (at < pnm.size() && (std::isspace(pnm[at]) || pnm[at] == '#')) {
      if (pnm[at] == '#')
        while (at < pnm.size() && pnm[at] != '\n') ++at;
      else
        ++at;
    }
    while (at < pnm.size() && std::isdigit(pnm[at]) && number < 1'000'000) number = number * 10 + (pnm[at++] - '0');
  }
  const uint64_t bytes = (pnm[1] == '6' ? 3 : 1) * (header[2] > 255 ? 2 : 1);
  return header[2] > 0 && pnm.size() >= at + 1 + header[0] * header[1] * bytes;
}

/// Its size stands in the header; 0 where the writer did not care.
bool bmp_is_whole(Bytes bmp) { return bmp.size() >= 54 && bmp.size() >= (bmp[2] | bmp[3] << 8 | bmp[4] << 16 | uint32_t{bmp[5]} << 24); }

bool is_whole(Bytes bytes) {
  if (begins(bytes, "\x89PNG\r\n\x1a\n")) return png_is_whole(bytes);
  if (begins(bytes, "\xff\xd8")) return jpeg_is_whole(bytes);
  if (begins(bytes, "P5") || begins(bytes, "P6")) return pnm_is_whole(bytes);
  if (begins(bytes, "BM")) return bmp_is_whole(bytes);
  return true;  // decoders of the other formats refuse half a file
}

/// Empty, or what is wrong with the file. Allocates only for a file larger than those before.
std::string load(const std::string& file, std::vector<uint8_t>& bytes) {
  const int in = open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (in < 0) return errno == ENOENT ? "is missing" : "cannot be read: " + std::generic_category().message(errno);
  struct stat status {};
  std::string why;
  if (fstat(in, &status) != 0 || !S_ISREG(status.st_mode))
    why = "is no file";
  else if (status.st_size == 0)
    why = "is empty";
  else if (status.st_size > largest)
    why = "is larger than 256 MiB";
  if (why.empty()) {
    bytes.resize(static_cast<size_t>(status.st_size));
    size_t done = 0;
    while (done < bytes.size()) {
      const ssize_t got = read(in, bytes.data() + done, bytes.size() - done);
      if (got <= 0) break;
      done += static_cast<size_t>(got);
    }
    if (done < bytes.size()) why = "cannot be read to its end";
  }
  close(in);
  return why;
}

double greatest(const cv::Mat& image) {
  double value = 0;
  cv::minMaxLoc(image, nullptr, &value);
  return value;
}

}  // namespace

bool ImagePairs::read(const std::string& file, cv::Mat& decoded, cv::Mat& gray) {
  std::string why = load(file, bytes_);
  if (why.empty() && !is_whole(bytes_)) why = "is truncated";
  if (why.empty()) {
    try {
      // A refused file would leave the picture before it.
      decoded.release();
      // Pixels as the camera saw them: a calibration knows nothing of an orientation tag.
      cv::imdecode(bytes_, cv::IMREAD_GRAYSCALE | cv::IMREAD_ANYDEPTH | cv::IMREAD_IGNORE_ORIENTATION, &decoded);
      if (decoded.empty())
        why = "is no image or damaged";
      else if (decoded.depth() != CV_8U && decoded.depth() != CV_16U)
        why = "has pixels that are neither 8 nor 16 bit";
    } catch (const cv::Exception& e) {
      why = "is refused by OpenCV: " + e.err;
    }
  }
  if (!why.empty()) {
    problem_ = file + " " + why;
    return false;
  }
  if (decoded.depth() == CV_16U)
    decoded.convertTo(gray, CV_8U, 255 / white_);
  else
    gray = decoded;
  return true;
}

std::vector<cv::Size> ImagePairs::survey(size_t most) {
  std::vector<cv::Size> sizes;
  std::string first_problem;
  double brightest = 0;
  while (sizes.size() < most) {
    const PairRead result = next();
    if (result == PairRead::end) break;
    if (result == PairRead::bad) {
      if (first_problem.empty()) first_problem = problem_;
      continue;
    }
    sizes.push_back(gray_[0].size());
    for (const cv::Mat& image : decoded_)
      if (image.depth() == CV_16U) brightest = std::max(brightest, greatest(image));
  }
  // All black tells nothing.
  if (brightest > 0) white_ = brightest < 1024 ? 1023 : brightest < 4096 ? 4095 : 65535;
  if (sizes.empty()) problem_ = first_problem;
  rewind();
  return sizes;
}

PairRead ImagePairs::next() {
  problem_.clear();
  if (next_ >= pairs_.size()) return PairRead::end;
  const PairName& pair = pairs_[next_++];
  if (!read(pair.left, decoded_[0], gray_[0]) || !read(pair.right, decoded_[1], gray_[1])) return PairRead::bad;
  if (gray_[0].size() == gray_[1].size()) return PairRead::good;
  problem_ = pair.left + " is " + size_text(gray_[0].size()) + ", " + pair.right + " is " + size_text(gray_[1].size());
  return PairRead::bad;
}

std::pair<std::string, std::string> ImagePairs::names() const {
  if (next_ == 0) return {};
  return {pairs_[next_ - 1].left, pairs_[next_ - 1].right};
}

int64_t ImagePairs::recorded_span_ns() const {
  const int64_t first = pairs_.front().recorded_ns, last = pairs_.back().recorded_ns;
  if (first < 0) return 0;
  const int64_t intervals = static_cast<int64_t>(pairs_.size()) - 1;
  return last - first + (intervals > 0 ? (last - first) / intervals : 1'000'000'000 / 30);
}

}  // namespace vdisp
