#pragma once

#include <array>
#include <cstddef>
#include <initializer_list>

#include "core/check.h"

namespace floatstage::render {

/// A list of at most N things, without memory of its own elsewhere.
template <class T, std::size_t N>
class ShortList {
 public:
  ShortList() = default;
  ShortList(std::initializer_list<T> values) {
    for (const T& value : values) push_back(value);
  }
  void push_back(const T& value) {
    FLOATSTAGE_CHECK(size_ < N, "a short list has room");
    values_[size_++] = value;
  }
  /// What is no longer listed stays, with its memory, for when it is listed again.
  void resize(std::size_t size) {
    FLOATSTAGE_CHECK(size <= N, "a short list has room");
    size_ = size;
  }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  T& operator[](std::size_t i) { return values_[i]; }
  const T& operator[](std::size_t i) const { return values_[i]; }
  T* data() { return values_.data(); }
  const T* data() const { return values_.data(); }
  T* begin() { return values_.data(); }
  T* end() { return values_.data() + size_; }
  const T* begin() const { return values_.data(); }
  const T* end() const { return values_.data() + size_; }

 private:
  std::array<T, N> values_{};
  std::size_t size_ = 0;
};

}  // namespace floatstage::render
