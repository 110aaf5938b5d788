#pragma once

// Counts what a program allocates, by replacing operator new: for one .cpp file of a test program of its own.

#include <atomic>
#include <cstdlib>
#include <new>

namespace floatstage::test {

inline std::atomic<long> allocations = 0;

inline void* counted(std::size_t size, std::size_t alignment) {
  ++allocations;
  void* memory = std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace floatstage::test

// g++ 12 inlines one half of the pair and then finds the other mismatched.
#pragma GCC diagnostic ignored "-Wmismatched-new-delete"

void* operator new(std::size_t size) { return floatstage::test::counted(size, 16); }
void* operator new[](std::size_t size) { return floatstage::test::counted(size, 16); }
void* operator new(std::size_t size, std::align_val_t a) {
  return floatstage::test::counted(size, static_cast<std::size_t>(a));
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
