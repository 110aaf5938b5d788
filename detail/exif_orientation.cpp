#include "detail/exif_orientation.h"

#include <algorithm>
#include <cstdint>
#include <cstring>

namespace floatstage::detail {
namespace {

constexpr int kOrientationTag = 0x0112, kShort = 3;
constexpr int kMostEntries = 1000;  // of a directory; a camera writes some twenty

std::uint32_t byte_at(std::string_view s, std::size_t at) {
  return at < s.size() ? static_cast<unsigned char>(s[at]) : 0U;
}

std::uint32_t number(std::string_view s, std::size_t at, int bytes, bool little) {
  std::uint32_t value = 0;
  for (int i = 0; i < bytes; ++i)
    value = value << 8 | byte_at(s, at + static_cast<std::size_t>(little ? bytes - 1 - i : i));
  return value;
}

// Of the first directory of a TIFF, which is what EXIF wraps, too.
int of_tiff(std::string_view tiff) {
  if (tiff.size() < 14) return 1;
  const bool little = tiff.starts_with(std::string_view("II*\0", 4));
  if (!little && !tiff.starts_with(std::string_view("MM\0*", 4))) return 1;
  const std::size_t directory = number(tiff, 4, 4, little);
  if (directory > tiff.size()) return 1;
  const int entries = std::min<int>(static_cast<int>(number(tiff, directory, 2, little)), kMostEntries);
  for (int i = 0; i < entries; ++i) {
    const std::size_t at = directory + 2 + 12 * static_cast<std::size_t>(i);
    if (at + 12 > tiff.size()) return 1;
    if (number(tiff, at, 2, little) != kOrientationTag || number(tiff, at + 2, 2, little) != kShort) continue;
    const int said = static_cast<int>(number(tiff, at + 8, 2, little));
    return said >= 1 && said <= 8 ? said : 1;
  }
  return 1;
}

int of_jpeg(std::string_view jpeg) {
  for (std::size_t at = 2; at + 4 <= jpeg.size();) {
    if (byte_at(jpeg, at) != 0xFF) return 1;
    const std::uint32_t marker = byte_at(jpeg, at + 1), length = number(jpeg, at + 2, 2, false);
    if (marker == 0xDA || marker == 0xD9 || length < 2) return 1;  // the picture itself begins
    const std::string_view segment = jpeg.substr(at + 4, length - 2);
    if (marker == 0xE1 && segment.starts_with(std::string_view("Exif\0\0", 6)))
      return of_tiff(segment.substr(6));
    at += 2 + length;
  }
  return 1;
}

int of_png(std::string_view png) {
  for (std::size_t at = 8; at + 12 <= png.size();) {
    const std::size_t length = number(png, at, 4, false);
    const std::string_view kind = png.substr(at + 4, 4);
    if (kind == "IEND" || length > png.size()) return 1;
    if (kind == "eXIf") return of_tiff(png.substr(at + 8, length));
    at += 12 + length;
  }
  return 1;
}

}  // namespace

int exif_orientation(std::string_view file) {
  if (file.starts_with("\xFF\xD8")) return of_jpeg(file);
  if (file.starts_with("\x89PNG")) return of_png(file);
  return of_tiff(file);
}

Image upright(Image picture, int orientation) {
  if (orientation < 2 || orientation > 8) return picture;
  const int w = picture.width, h = picture.height;
  const bool transposed = orientation >= 5;
  // Where the shown picture's pixel lies in the stored one: after a transposition, mirrored along x and y.
  const bool mirror_x = orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8;
  const bool mirror_y = orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
  Image out(transposed ? h : w, transposed ? w : h, picture.channels);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      const int u = transposed ? y : x, v = transposed ? x : y;
      std::memcpy(out.at(x, y), picture.at(mirror_x ? w - 1 - u : u, mirror_y ? h - 1 - v : v),
                  static_cast<std::size_t>(picture.channels));
    }
  return out;
}

}  // namespace floatstage::detail
