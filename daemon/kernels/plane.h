// plane.h: a rectangle of pixels as the kernels see it: a pointer, a size and a stride; nothing about what it shows.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

namespace vdisp::kernels {

/// `stride` counts elements of T from one row to the next; it may exceed the width by any number. Nothing is owned.
template <class T>
struct Plane {
  T* data = nullptr;
  int width = 0, height = 0;
  ptrdiff_t stride = 0;

  T* row(int y) const { return data + y * stride; }
  operator Plane<const T>() const { return {data, width, height, stride}; }
};

using View8 = Plane<const uint8_t>;

}  // namespace vdisp::kernels
