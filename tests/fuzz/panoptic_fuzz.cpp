#include <cstdint>
#include <string_view>

#include "tests/fuzz/foreign_rig.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  const std::string_view input(reinterpret_cast<const char*>(data), size);
  expect_sound(calib::parse_panoptic(input, "calibration_x.json"));
  return 0;
}
