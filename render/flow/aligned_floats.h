#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <new>

namespace floatstage::render {

/// Floats that begin at a cache line and keep their memory when they shrink.
class AlignedFloats {
 public:
  /// `size` zeros.
  void reset(std::size_t size) {
    if (size > capacity_) {
      values_.reset(static_cast<float*>(::operator new(size * sizeof(float), kLine)));
      capacity_ = size;
    }
    std::fill(values_.get(), values_.get() + size, 0.F);
  }
  float* data() { return values_.get(); }
  const float* data() const { return values_.get(); }

 private:
  static constexpr std::align_val_t kLine{64};
  struct Free {
    void operator()(float* values) const { ::operator delete(values, kLine); }
  };
  std::unique_ptr<float[], Free> values_;
  std::size_t capacity_ = 0;
};

}  // namespace floatstage::render
