#include <cstdint>
#include <string_view>

#include "tests/fuzz/foreign_rig.h"

// The input holds two files with a line of === between them. Whatever parses is a rig of finite cameras.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  const std::string_view input(reinterpret_cast<const char*>(data), size);
  const auto [intri, extri] = two_files(input);
  expect_sound(calib::parse_easymocap(intri, extri, "intri", "extri"));
  return 0;
}
