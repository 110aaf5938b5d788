#include "core/serial.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <string>

namespace floatstage {

std::string_view without_media_extension(std::string_view name) {
  constexpr std::array<std::string_view, 19> kMedia = {
      ".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp",  ".ppm", ".pgm", ".webp", ".exr",
      ".mp4", ".mkv", ".mov",  ".avi", ".m4v",  ".webm", ".mpg", ".mts", ".gif"};
  const std::size_t dot = name.rfind('.');
  if (dot == std::string_view::npos || dot == 0) return name;
  std::string extension(name.substr(dot));
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::find(kMedia.begin(), kMedia.end(), extension) == kMedia.end() ? name : name.substr(0, dot);
}

}  // namespace floatstage
