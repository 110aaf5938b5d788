#include <cstdint>
#include <string_view>

#include "capture/added_file.h"
#include "core/check.h"

// Whatever parses is written and read back the same.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  const auto added = capture::parse_added({reinterpret_cast<const char*>(data), size}, "fuzz");
  if (!added) return 0;
  const auto again = capture::parse_added(to_json(*added), "again");
  FLOATSTAGE_CHECK(again && *again == *added, "added content that changes when it is written");
  return 0;
}
