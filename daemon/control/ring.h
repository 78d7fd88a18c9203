// ring.h: a queue between two threads, one that fills and one that empties: no lock, no allocation after the start.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <vector>

namespace vdisp {

template <class Item>
class Ring {
 public:
  explicit Ring(size_t places) : items_(places) {}

  /// The place to fill next; null while all are full. The filling thread's.
  Item* free_place() {
    return filled_.load(std::memory_order_relaxed) - emptied_.load(std::memory_order_acquire) < items_.size()
               ? &items_[filled_.load(std::memory_order_relaxed) % items_.size()]
               : nullptr;
  }
  void push() { filled_.fetch_add(1, std::memory_order_release); }

  /// The oldest item; null where there is none. The emptying thread's.
  Item* front() {
    return emptied_.load(std::memory_order_relaxed) != filled_.load(std::memory_order_acquire)
               ? &items_[emptied_.load(std::memory_order_relaxed) % items_.size()]
               : nullptr;
  }
  void pop() { emptied_.fetch_add(1, std::memory_order_release); }

 private:
  std::vector<Item> items_;
  alignas(64) std::atomic<size_t> filled_{0};
  alignas(64) std::atomic<size_t> emptied_{0};
};

}  // namespace vdisp
