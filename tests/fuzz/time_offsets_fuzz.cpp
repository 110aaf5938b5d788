#include <cstdint>
#include <string_view>

#include "capture/time_offsets.h"
#include "core/check.h"

// Whatever parses is written and read back the same.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  const auto times = capture::parse_time_offsets({reinterpret_cast<const char*>(data), size}, "fuzz");
  if (!times) return 0;
  const auto again = capture::parse_time_offsets(to_json(*times), "again");
  FLOATSTAGE_CHECK(again && *again == *times, "times that change when they are written");
  return 0;
}
