#include <cstdint>

#include "tests/fuzz/foreign_rig.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  expect_sound(calib::parse_kalibr({reinterpret_cast<const char*>(data), size}, "fuzz"));
  return 0;
}
