#include "capture/ffv1_check.h"

extern "C" {
#include <libavutil/crc.h>
}

namespace floatstage::capture {

bool ffv1_intact(std::span<const std::uint8_t> picture) {
  constexpr std::size_t kFooter = 8;  // 3 bytes of size, 1 of error status, 4 of CRC
  const AVCRC* table = av_crc_get_table(AV_CRC_32_IEEE);
  if (picture.empty()) return false;
  while (!picture.empty()) {
    if (picture.size() < kFooter) return false;
    const std::uint8_t* footer = picture.data() + picture.size() - kFooter;
    const std::size_t size =
        (std::size_t{footer[0]} << 16 | std::size_t{footer[1]} << 8 | footer[2]) + kFooter;
    if (size > picture.size()) return false;
    if (av_crc(table, 0, picture.data() + picture.size() - size, size) != 0) return false;
    picture = picture.first(picture.size() - size);
  }
  return true;
}

}  // namespace floatstage::capture
