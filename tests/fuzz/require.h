// require.h: what must hold of any input; libFuzzer takes an abort for a find.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>

namespace vdisp {

inline void require(bool holds, std::string_view what) {
  if (holds) return;
  std::fprintf(stderr, "broken: %.*s\n", static_cast<int>(what.size()), what.data());
  std::abort();
}

/// What a complaint must be.
inline bool is_one_line(std::string_view text) {
  for (const char c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) return false;
  return !text.empty();
}

/// Takes an input apart from its front; what is missing at its end is 0.
class Bytes {
 public:
  Bytes(const uint8_t* data, size_t size) : data_(data), size_(size) {}
  bool empty() const { return size_ == 0; }
  size_t size() const { return size_; }
  /// As many as there are, of `size`; the rest of `to` stays.
  void copy(void* to, size_t size) {
    const size_t count = size < size_ ? size : size_;
    if (count > 0) std::memcpy(to, data_, count);
    data_ += count;
    size_ -= count;
  }
  template <class Number>
  Number number() {
    Number value{};
    copy(&value, sizeof value);
    return value;
  }
  std::string text(size_t size) {
    std::string text(size < size_ ? size : size_, '\0');
    copy(text.data(), text.size());
    return text;
  }

 private:
  const uint8_t* data_;
  size_t size_;
};

}  // namespace vdisp
