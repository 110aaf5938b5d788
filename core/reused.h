#pragma once

#include <algorithm>
#include <memory>
#include <vector>

namespace floatstage {

/// Objects that are handed out and, once nobody else has them any more, handed out again with the memory that
/// they hold. As many are kept as were in use at once. take() by one thread at a time; what was taken may be
/// passed on and dropped on any thread, also after this. Nobody may keep a weak_ptr to it.
template <class T>
class Reused {
 public:
  Reused() = default;
  Reused(Reused&&) noexcept = default;  // two that have the same objects would never find one free
  Reused& operator=(Reused&&) noexcept = default;

  /// One that nobody else has: new, or as its last user left it.
  std::shared_ptr<T> take() {
    const auto free = [](const std::shared_ptr<T>& kept) { return kept.use_count() == 1; };
    const auto found = std::find_if(kept_.begin(), kept_.end(), free);
    // use_count() is a relaxed read and orders nothing. The copy does: it counts up with an operation that
    // acquires (libstdc++: fetch_add, acq_rel) what the last user released when it counted down.
    return found != kept_.end() ? *found : kept_.emplace_back(std::make_shared<T>());
  }

 private:
  std::vector<std::shared_ptr<T>> kept_;
};

}  // namespace floatstage
