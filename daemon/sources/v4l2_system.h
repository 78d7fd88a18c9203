// v4l2_system.h: the calls to the kernel that the V4L2 driver makes, as a table that a test can fill otherwise.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace vdisp {

/// All as the kernel has them: -1 (map: null) and errno where they fail.
class V4l2System {
 public:
  virtual ~V4l2System() = default;
  /// /dev/video*, in the order of their numbers.
  virtual std::vector<std::string> devices() = 0;
  virtual int open(const char* path) = 0;  ///< read and write, not blocking
  virtual int close(int file) = 0;
  virtual int control(int file, unsigned long request, void* argument) = 0;  ///< ioctl, again where a signal came
  virtual void* map(int file, size_t bytes, long offset) = 0;
  virtual void unmap(void* memory, size_t bytes) = 0;
  /// 1: something is there, 0: not in time, -1: the device is gone.
  virtual int wait(int file, int timeout_ms) = 0;
};

/// The kernel's.
V4l2System& v4l2_system();

}  // namespace vdisp
