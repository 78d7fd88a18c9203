// shm_outlet.h: a topic in shared memory: images are written where readers will find them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <iceoryx_posh/internal/mepoo/memory_manager.hpp>
#include <iceoryx_posh/popo/untyped_publisher.hpp>

#include "ipc/outlet.h"

namespace vdisp {

class ShmOutlet final : public Outlet {
 public:
  /// `pool` of `memory` has blocks of exactly block_bytes.
  ShmOutlet(const iox::capro::ServiceDescription& service, const ImageSpec& spec, uint32_t block_bytes,
            const iox::mepoo::MemoryManager& memory, uint32_t pool);
  bool watched() const noexcept override { return publisher_.hasSubscribers(); }
  Image& loan() noexcept override;
  void publish() noexcept override;
  uint64_t drops() const noexcept override { return drops_; }

 private:
  struct Free {
    void operator()(std::byte* memory) const { std::free(memory); }
  };
  iox::popo::UntypedPublisher publisher_;
  ImageSpec spec_;
  uint32_t block_bytes_;
  const iox::mepoo::MemoryManager& memory_;
  uint32_t pool_;
  std::unique_ptr<std::byte[], Free> spare_;
  Image* image_ = nullptr;
  uint64_t drops_ = 0;
};

}  // namespace vdisp
