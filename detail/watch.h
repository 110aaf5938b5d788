#pragma once

#include <cstddef>
#include <functional>

namespace floatstage::detail {

/// How long work is watched, and stopped; any may be empty. Called from any thread.
struct Watch {
  std::function<void(const char* what, std::size_t total)> begin;  ///< a part of so many items begins
  std::function<void()> advance;                                   ///< one of them is done
  std::function<void()> end;
  std::function<bool()> cancelled;  ///< whether to end between two items

  bool is_cancelled() const { return cancelled && cancelled(); }
};

}  // namespace floatstage::detail
