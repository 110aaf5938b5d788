#include <cstdint>
#include <string_view>

#include "tests/fuzz/foreign_rig.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  const std::string_view input(reinterpret_cast<const char*>(data), size);
  const calib::PictureSize size_of = [](const std::string&) -> Result<std::pair<int, int>> {
    return std::pair(64, 48);
  };
  expect_sound(calib::parse_transforms(input, size_of, "transforms.json"));
  return 0;
}
