#include "capture/sha256.h"

extern "C" {
#include <libavutil/mem.h>
#include <libavutil/sha.h>
}

#include <array>
#include <cstdint>
#include <memory>

#include "core/check.h"

namespace floatstage::capture {

std::string sha256(std::string_view bytes) {
  const std::unique_ptr<AVSHA, decltype(&av_free)> state(av_sha_alloc(), &av_free);
  FLOATSTAGE_CHECK(state != nullptr && av_sha_init(state.get(), 256) == 0, "libavutil without SHA-256");
  av_sha_update(state.get(), reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  std::array<std::uint8_t, 32> digest;
  av_sha_final(state.get(), digest.data());
  std::string hex;
  for (const std::uint8_t byte : digest) {
    hex += "0123456789abcdef"[byte >> 4];
    hex += "0123456789abcdef"[byte & 15];
  }
  return hex;
}

}  // namespace floatstage::capture
