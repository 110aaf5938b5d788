#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace floatstage::capture {

/// Buffers that a V4L2 output device lends by memory mapping (V4L2's streaming I/O). For one thread; the
/// device stays open meanwhile, and takes them back when it is closed.
class V4l2OutputBuffers {
 public:
  V4l2OutputBuffers() = default;
  ~V4l2OutputBuffers();
  V4l2OutputBuffers(const V4l2OutputBuffers&) = delete;
  V4l2OutputBuffers& operator=(const V4l2OutputBuffers&) = delete;

  /// Once, after the format is set. 0 or an errno.
  int start(int device);
  /// Copies one picture into a free buffer and hands it over. 0 or an errno: EAGAIN while none is free,
  /// EMSGSIZE where the buffers are smaller.
  int put(std::span<const std::uint8_t> picture);

 private:
  int device_ = -1;
  std::vector<std::span<std::uint8_t>> maps_;
  std::size_t used_ = 0;  // of maps_, handed over at least once
  bool streams_ = false;
};

}  // namespace floatstage::capture
