#include <cstdint>
#include <string_view>

#include "calib/observations.h"
#include "core/check.h"

// Whatever parses passes its own check and is written as a document that parses to the same.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  const Result<calib::Observations> seen =
      calib::parse_observations({reinterpret_cast<const char*>(data), size}, "fuzz");
  if (!seen) return 0;
  FLOATSTAGE_CHECK(check(*seen), "parsed, but does not pass check()");
  const Result<calib::Observations> again = calib::parse_observations(to_json(*seen), "again");
  FLOATSTAGE_CHECK(again, "what we wrote does not parse: " + again.error().message);
  FLOATSTAGE_CHECK(to_json(*again) == to_json(*seen), "changed by a round trip");
  return 0;
}
