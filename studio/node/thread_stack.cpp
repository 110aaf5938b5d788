#include "studio/node/thread_stack.h"

#include <algorithm>

#include <dlfcn.h>
#include <pthread.h>

// Stands before the C library's, for all shared libraries of the program.
extern "C" __attribute__((visibility("default"))) int pthread_attr_setstacksize(pthread_attr_t* attributes,
                                                                                std::size_t size) noexcept {
  using Function = int (*)(pthread_attr_t*, std::size_t);
  const auto next = reinterpret_cast<Function>(::dlsym(RTLD_NEXT, "pthread_attr_setstacksize"));
  return next(attributes, std::max(size, floatstage::studio::kSmallestStack));
}

namespace floatstage::studio {

bool small_stacks_are_raised() {
  pthread_attr_t attributes;
  ::pthread_attr_init(&attributes);
  std::size_t size = 0;
  const bool raised = ::pthread_attr_setstacksize(&attributes, 100 << 10) == 0 &&
                      ::pthread_attr_getstacksize(&attributes, &size) == 0 && size >= kSmallestStack;
  ::pthread_attr_destroy(&attributes);
  return raised;
}

}  // namespace floatstage::studio
