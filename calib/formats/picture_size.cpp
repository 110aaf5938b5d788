#include "calib/formats/picture_size.h"

#include "core/file.h"
#include "core/text.h"

namespace floatstage::calib {

std::optional<PictureSizePx> size_in_header(std::string_view bytes) {
  auto byte = [&](std::size_t i) { return i < bytes.size() ? static_cast<unsigned char>(bytes[i]) : 0; };
  auto word = [&](std::size_t i) { return byte(i) << 8 | byte(i + 1); };
  if (bytes.substr(0, 4) == "\x89PNG" && bytes.size() > 24)
    return PictureSizePx{word(16) << 16 | word(18), word(20) << 16 | word(22)};
  if (bytes.substr(0, 2) != "\xff\xd8") return std::nullopt;
  for (std::size_t at = 2; at + 9 < bytes.size() && byte(at) == 0xff;) {
    const int marker = byte(at + 1), length = word(at + 2);
    const bool frame = marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (frame) return PictureSizePx{word(at + 7), word(at + 5)};
    if (length < 2) break;
    at += 2 + static_cast<std::size_t>(length);
  }
  return std::nullopt;
}

Result<PictureSizePx> size_of_picture(const std::filesystem::path& picture) {
  const Result<std::string> bytes = read_file(picture);
  if (!bytes) return forward(bytes);
  const std::optional<PictureSizePx> size = size_in_header(*bytes);
  if (!size || size->width < 1 || size->height < 1)
    return fail(ErrorCode::BadData,
                text(picture.string(), ": is no whole JPEG or PNG: its size is not to be read"));
  return *size;
}

}  // namespace floatstage::calib
