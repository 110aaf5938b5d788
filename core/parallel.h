#pragma once

#include <cstddef>
#include <memory>
#include <type_traits>

namespace floatstage {

/// A reference to something that can be called with an index, without owning or allocating anything.
class IndexBody {
 public:
  template <class Body, class = std::enable_if_t<!std::is_same_v<std::decay_t<Body>, IndexBody>>>
  IndexBody(Body&& body)  // NOLINT(*-explicit-*, *-forwarding-reference-overload)
      : object_(const_cast<void*>(static_cast<const void*>(std::addressof(body)))),
        call_(
            [](void* object, std::size_t i) { (*static_cast<std::remove_reference_t<Body>*>(object))(i); }) {}
  void operator()(std::size_t i) const { call_(object_, i); }

 private:
  void* object_;
  void (*call_)(void*, std::size_t);
};

/// Runs body(i) for every i in [0, count) on up to `threads` threads (0: one per core; 1: on this thread, in
/// order). Items are handed out one at a time; results must not depend on the order, which is what keeps
/// outputs the same at any thread count. The first exception thrown by a body is rethrown here after all
/// threads have stopped. The other threads are kept for all calls (docs/adr/0164): a call takes those that
/// have nothing to do, so an item may wait for those before it, which are handed out in order, if none of
/// them throws, but for none after it; and a body may call parallel_for() itself. Nothing is allocated once
/// as many threads have been asked for before.
void parallel_for(std::size_t count, int threads, IndexBody body);

/// What `threads = 0` means on this machine.
int default_threads();

}  // namespace floatstage
