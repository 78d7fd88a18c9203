// v4l2_system.cpp: the kernel itself.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/sources/v4l2_system.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <system_error>

namespace vdisp {
namespace {

class Kernel final : public V4l2System {
 public:
  std::vector<std::string> devices() override {
    std::vector<std::pair<int, std::string>> found;
    std::error_code error;
    for (std::filesystem::directory_iterator i("/dev", error), end; !error && i != end; i.increment(error)) {
      const std::string name = i->path().filename().string();
      if (name.starts_with("video") && name.size() > 5 && name.size() < 10 && name.find_first_not_of("0123456789", 5) == std::string::npos)
        found.emplace_back(std::stoi(name.substr(5)), i->path().string());
    }
    std::sort(found.begin(), found.end());
    std::vector<std::string> names;
    for (auto& [number, name] : found) names.push_back(std::move(name));
    return names;
  }
  int open(const char* path) override { return ::open(path, O_RDWR | O_NONBLOCK | O_CLOEXEC); }
  int close(int file) override { return ::close(file); }
  int control(int file, unsigned long request, void* argument) override {
    int result;
    do result = ::ioctl(file, request, argument);
    while (result < 0 && errno == EINTR);
    return result;
  }
  void* map(int file, size_t bytes, long offset) override {
    void* memory = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file, offset);
    return memory == MAP_FAILED ? nullptr : memory;
  }
  void unmap(void* memory, size_t bytes) override { ::munmap(memory, bytes); }
  int wait(int file, int timeout_ms) override {
    pollfd ready{file, POLLIN, 0};
    const int count = ::poll(&ready, 1, timeout_ms);
    if (count < 0) return errno == EINTR ? 0 : -1;
    if (count == 0) return 0;
    return ready.revents & POLLIN ? 1 : -1;
  }
};

}  // namespace

V4l2System& v4l2_system() {
  static Kernel kernel;
  return kernel;
}

}  // namespace vdisp
