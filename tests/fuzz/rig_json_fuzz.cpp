#include <cstdint>
#include <string_view>

#include "core/check.h"
#include "core/rig_io.h"

// Whatever parses is a rig that passes its own check and is written as a document that parses to the same.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  const Result<Rig> rig = parse_rig({reinterpret_cast<const char*>(data), size}, "fuzz");
  if (!rig) return 0;
  FLOATSTAGE_CHECK(check(*rig), "parsed, but does not pass check()");
  const Result<Rig> again = parse_rig(to_json(*rig), "again");
  FLOATSTAGE_CHECK(again, "what we wrote does not parse: " + again.error().message);
  FLOATSTAGE_CHECK(to_json(*again) == to_json(*rig), "changed by a round trip");
  return 0;
}
