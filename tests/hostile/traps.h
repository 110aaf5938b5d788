#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace floatstage {

/// What stands where a file stood that had these bytes.
struct Trap {
  const char* name;
  std::function<void(const std::filesystem::path& file, const std::string& was)> set;
};

/// Damaged and hostile bytes, and what is no regular file.
const std::vector<Trap>& traps();

/// Pictures and films that claim more than they hold, or lead somewhere else, by name.
struct Bomb {
  const char* name;
  std::string bytes;
};
const std::vector<Bomb>& media_bombs();

/// A TIFF up to its samples, which would begin at byte 122: grey, of any size, in one strip that lies
/// anywhere, coded by a scheme of libtiff's; 1: not at all.
std::string tiff_claiming(std::uint32_t width, std::uint32_t height, std::uint32_t strip_at,
                          std::uint32_t strip_bytes, std::uint32_t coding = 1);

}  // namespace floatstage
