// A program of its own: it replaces operator new to count.

#include <atomic>
#include <cstdlib>
#include <new>

#include "render/flow/variational_flow.h"
#include "tests/render/flow/pictures.h"
#include "tests/support/matchers.h"

namespace {
std::atomic<long> allocations = 0;
void* counted(std::size_t size, std::size_t alignment) {
  ++allocations;
  void* memory = std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
}  // namespace

// g++ 12 inlines one half of the pair and then finds the other mismatched.
#pragma GCC diagnostic ignored "-Wmismatched-new-delete"

void* operator new(std::size_t size) { return counted(size, 16); }
void* operator new[](std::size_t size) { return counted(size, 16); }
void* operator new(std::size_t size, std::align_val_t a) {
  return counted(size, static_cast<std::size_t>(a));
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }

namespace floatstage::render::test {
namespace {

TEST(VariationalFlow, AllocatesNothingOnceItHasSeenPicturesOfASize) {
  FlowOptions options;
  options.finest_scale = 1;
  auto estimator = std::move(*make_variational_flow(options));
  std::vector<FlowField> fields(2);
  const FlowPair pairs[] = {{0, 1}, {1, 0}};
  bool first_time = true;
  for (const auto& [width, height] : {std::pair(160, 120), std::pair(130, 111), std::pair(160, 120)}) {
    const auto a = wavy(width, height, 0, 0), b = wavy(width, height, 2, 1), state = disc(width, height);
    const FlowImage images[] = {{width, height, a.data(), state.data()},
                                {width, height, b.data(), state.data()}};
    const long before = allocations;
    const Result<void> ok = estimator->estimate(images, pairs, {}, 1, fields);
    const long during = allocations - before;
    ASSERT_THAT(ok, IsOk());
    if (first_time) {
      EXPECT_GT(during, 0) << "the counter counts";
    } else {
      EXPECT_EQ(during, 0) << width << "x" << height;
    }
    first_time = false;
  }
}

}  // namespace
}  // namespace floatstage::render::test
