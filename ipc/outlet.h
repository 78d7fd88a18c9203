// outlet.h: where a stage's image goes: shared memory in the daemon, a buffer in tests and for --dump.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>

#include "ipc/image.h"

namespace vdisp {

/// One topic's way out. One image is loaned at a time: loan(), fill, publish(); after publish() it belongs to the readers.
class Outlet {
 public:
  virtual ~Outlet() = default;
  /// True while a reader is attached.
  virtual bool watched() const noexcept = 0;
  /// Never fails: where readers hold every block it is a private spare, and publish() counts a drop. Without a publish() in
  /// between it is the same image again.
  virtual Image& loan() noexcept = 0;
  virtual void publish() noexcept = 0;
  /// Images that no reader could get because readers held every block.
  virtual uint64_t drops() const noexcept = 0;
};

using OutletFactory = std::function<std::unique_ptr<Outlet>(const std::string& topic, const ImageSpec& spec)>;

/// A private buffer: nobody else reads it; it stays as published until the next loan.
class BufferOutlet final : public Outlet {
 public:
  explicit BufferOutlet(const ImageSpec& spec)
      : memory_(static_cast<std::byte*>(std::aligned_alloc(64, spec.bytes()))), image_(Image::make(memory_.get(), spec)) {}
  bool watched() const noexcept override { return watched_; }
  Image& loan() noexcept override { return *image_; }
  void publish() noexcept override { ++published_; }
  uint64_t drops() const noexcept override { return 0; }

  void watch(bool on) { watched_ = on; }
  uint64_t published() const { return published_; }

 private:
  struct Free {
    void operator()(std::byte* memory) const { std::free(memory); }
  };
  std::unique_ptr<std::byte[], Free> memory_;
  Image* image_;
  bool watched_ = false;
  uint64_t published_ = 0;
};

}  // namespace vdisp
