#include <cstdint>
#include <string>
#include <string_view>

#include "tests/fuzz/foreign_rig.h"

// Two views of a scene, the second with its original picture only.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  const auto [first, second] = two_files({reinterpret_cast<const char*>(data), size});
  calib::MveView straight{"view_0000.mve", std::string(first), "undistorted.png", true, 640, 480},
      bent{"view_0001.mve", std::string(second), "original.jpg", false, 480, 640};
  expect_sound(calib::parse_mve({straight, bent}, "views"));
  return 0;
}
