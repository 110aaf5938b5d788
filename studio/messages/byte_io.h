#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>

namespace floatstage::studio::wire {

static_assert(std::endian::native == std::endian::little, "messages are little-endian");

/// Appends numbers to bytes.
class ByteWriter {
 public:
  explicit ByteWriter(std::string& bytes) : bytes_(bytes) {}

  template <class Number>
  void put(Number number) {
    bytes_.append(reinterpret_cast<const char*>(&number), sizeof number);
  }
  /// Seven bits a byte, least first; small numbers are short.
  void put_varint(std::uint64_t number) {
    for (; number >= 0x80; number >>= 7) bytes_ += static_cast<char>(number | 0x80);
    bytes_ += static_cast<char>(number);
  }
  /// Small numbers of either sign are short.
  void put_signed(std::int64_t number) {
    put_varint((static_cast<std::uint64_t>(number) << 1) ^ static_cast<std::uint64_t>(number >> 63));
  }
  void put_bytes(std::string_view more) { bytes_ += more; }

 private:
  std::string& bytes_;
};

/// Reads numbers from bytes that may be anything. After the first one that is not there everything reads as
/// zero and good() is false, so that one question at the end is enough.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : rest_(bytes) {}

  template <class Number>
  Number get() {
    Number number{};
    const std::string_view bytes = get_bytes(sizeof number);
    if (!bytes.empty()) std::memcpy(&number, bytes.data(), sizeof number);
    return number;
  }
  std::uint64_t get_varint() {
    std::uint64_t number = 0;
    for (int shift = 0; shift < 64; shift += 7) {
      const auto byte = get<std::uint8_t>();
      if (shift == 63 && byte > 1) break;
      number |= static_cast<std::uint64_t>(byte & 0x7f) << shift;
      if (byte < 0x80) return good_ ? number : 0;
    }
    give_up();
    return 0;
  }
  std::int64_t get_signed() {
    const std::uint64_t number = get_varint();
    return static_cast<std::int64_t>((number >> 1) ^ (~(number & 1) + 1));
  }
  /// A number of things of which each takes `least` bytes or more: more than can follow is refused before any
  /// memory is taken for them.
  std::size_t get_count(std::size_t least) {
    const std::uint64_t count = get_varint();
    if (count > rest_.size() / least) give_up();
    return good_ ? static_cast<std::size_t>(count) : 0;
  }
  std::string_view get_bytes(std::size_t count) {
    if (count > rest_.size()) give_up();
    if (!good_) return {};
    const std::string_view bytes = rest_.substr(0, count);
    rest_.remove_prefix(count);
    return bytes;
  }
  std::string_view rest() const { return rest_; }
  bool good() const { return good_; }
  /// Everything was there and nothing is left over.
  bool done() const { return good_ && rest_.empty(); }

 private:
  void give_up() {
    good_ = false;
    rest_ = {};
  }
  std::string_view rest_;
  bool good_ = true;
};

inline std::span<const std::byte> as_bytes(std::string_view bytes) {
  return std::as_bytes(std::span(bytes.data(), bytes.size()));
}

}  // namespace floatstage::studio::wire
