/// Memory for arrays of many megabytes, in large pages where the system has them.
#pragma once

#include <cstddef>
#include <new>
#include <vector>

#include "core/layers.h"

namespace partscribe::core {

/// Aligned to at least a line of the cache.
void* take_large_memory(std::size_t bytes);
void give_back_large_memory(void* memory);

/// For std::vector. Touching a page of 4 kB for the first time takes as long as finding the neighbours of ten points.
/// Elements without a value are what their constructor makes of them: numbers are left undefined.
template <class T>
struct LargeAllocator {
  using value_type = T;
  LargeAllocator() = default;
  template <class U>
  LargeAllocator(const LargeAllocator<U>&) {}
  T* allocate(std::size_t count) { return static_cast<T*>(take_large_memory(count * sizeof(T))); }
  void deallocate(T* memory, std::size_t) { give_back_large_memory(memory); }
  template <class U>
  void construct(U* element) {
    ::new (static_cast<void*>(element)) U;
  }
  friend bool operator==(const LargeAllocator&, const LargeAllocator&) { return true; }
};

template <class T>
using LargeVector = std::vector<T, LargeAllocator<T>>;

}  // namespace partscribe::core
