#include <algorithm>
#include <cstdint>
#include <string_view>

#include "tests/fuzz/foreign_rig.h"

// The input holds two files with a line of === between them. Whatever parses is a rig of finite cameras.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  const std::string_view input(reinterpret_cast<const char*>(data), size);
  constexpr std::string_view kBetween = "\n===\n";
  const std::size_t at = std::min(input.find(kBetween), input.size());
  const std::string_view images = at < size ? input.substr(at + kBetween.size()) : std::string_view();
  expect_sound(calib::parse_colmap_binary(input.substr(0, at), images, "cameras", "images"));
  return 0;
}
