#include "core/content_hash.h"

#include <array>
#include <cstdint>
#include <cstdio>

#include "core/random.h"

namespace floatstage {

// 128 bits of a hash that nobody has a reason to attack: eight bytes at a time, mixed.
std::string content_hash(std::string_view bytes) {
  std::uint64_t a = mix(bytes.size()), b = mix(~bytes.size());
  for (std::size_t at = 0; at < bytes.size(); at += 8) {
    std::uint64_t word = 0;
    for (std::size_t i = 0; i < 8 && at + i < bytes.size(); ++i)
      word |= static_cast<std::uint64_t>(static_cast<unsigned char>(bytes[at + i])) << (8 * i);
    a = mix(a ^ word);
    b = mix(b + word * 0x9e3779b97f4a7c15ULL);
  }
  std::array<char, 33> hex{};
  std::snprintf(hex.data(), hex.size(), "%016llx%016llx", static_cast<unsigned long long>(a),
                static_cast<unsigned long long>(b));
  return {hex.data(), 32};
}

}  // namespace floatstage
