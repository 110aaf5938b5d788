#include <cstdint>
#include <string_view>

#include "calib/detect.h"
#include "core/check.h"

// Whatever parses is written and read back the same.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  const std::string_view input(reinterpret_cast<const char*>(data), size);
  if (const Result<calib::Detection> detection = calib::parse_detection(input, "fuzz")) {
    const Result<calib::Detection> again = calib::parse_detection(calib::to_text(*detection), "again");
    FLOATSTAGE_CHECK(again && *again == *detection, "a detection that changes when it is written");
  }
  return 0;
}
