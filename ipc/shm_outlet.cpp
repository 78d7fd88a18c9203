// shm_outlet.cpp: loan from the pool, or the spare where readers hold every block.
// SPDX-License-Identifier: Apache-2.0
#include "ipc/shm_outlet.h"

#include <cstring>

namespace vdisp {
namespace {

iox::popo::PublisherOptions options() {
  iox::popo::PublisherOptions options;
  options.historyCapacity = 1;
  return options;
}

}  // namespace

ShmOutlet::ShmOutlet(const iox::capro::ServiceDescription& service, const ImageSpec& spec, uint32_t block_bytes,
                     const iox::mepoo::MemoryManager& memory, uint32_t pool)
    : publisher_(service, options()),
      spec_(spec),
      block_bytes_(block_bytes),
      memory_(memory),
      pool_(pool),
      spare_(static_cast<std::byte*>(std::aligned_alloc(64, spec.bytes()))) {
  std::memset(spare_.get(), 0, spec.bytes());  // touched now, not in the loop
}

Image& ShmOutlet::loan() noexcept {
  if (image_) return *image_;
  void* memory = spare_.get();
  // A loan that fails prints and allocates inside iceoryx. Only this process takes blocks, so one that is free stays free.
  const iox::mepoo::MemPoolInfo info = memory_.getMemPoolInfo(pool_);
  if (info.m_usedChunks < info.m_numChunks) {
    auto loaned = publisher_.loan(block_bytes_, alignof(Image));
    if (!loaned.has_error()) memory = loaned.value();
  }
  image_ = Image::make(memory, spec_);
  return *image_;
}

void ShmOutlet::publish() noexcept {
  if (!image_) return;
  if (reinterpret_cast<std::byte*>(image_) == spare_.get())
    ++drops_;
  else
    publisher_.publish(image_);
  image_ = nullptr;
}

}  // namespace vdisp
