#pragma once

#include <bit>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>

namespace floatstage::calib {

static_assert(std::endian::native == std::endian::little,
              "binary calibrations are little-endian, and so are we");

/// Little-endian numbers one after the other. Borrows the bytes. Every read may find the end: nothing then.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : bytes_(bytes) {}

  std::size_t position() const { return position_; }
  std::size_t remaining() const { return bytes_.size() - position_; }

  template <class T>
  std::optional<T> next() {
    if (remaining() < sizeof(T)) return std::nullopt;
    T value;
    std::memcpy(&value, bytes_.data() + position_, sizeof(T));
    position_ += sizeof(T);
    return value;
  }

  /// Up to a zero byte, which is passed over.
  std::optional<std::string> next_name() {
    const std::size_t end = bytes_.find('\0', position_);
    if (end == bytes_.npos) return std::nullopt;
    std::string name(bytes_.substr(position_, end - position_));
    position_ = end + 1;
    return name;
  }

  bool skip(std::size_t bytes) {
    if (remaining() < bytes) return false;
    position_ += bytes;
    return true;
  }

 private:
  std::string_view bytes_;
  std::size_t position_ = 0;
};

}  // namespace floatstage::calib
