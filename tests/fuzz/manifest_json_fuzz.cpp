#include <cstdint>
#include <string_view>

#include "core/check.h"
#include "core/take_layout.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  const Result<TakeManifest> manifest = parse_manifest({reinterpret_cast<const char*>(data), size}, "fuzz");
  if (!manifest) return 0;
  for (const TakeManifest::Camera& c : manifest->cameras)
    FLOATSTAGE_CHECK(c.media.find('/') == std::string::npos && c.media != "..",
                     "a media file outside the take");
  const Result<TakeManifest> again = parse_manifest(to_json(*manifest), "again");
  FLOATSTAGE_CHECK(again, "what we wrote does not parse: " + again.error().message);
  FLOATSTAGE_CHECK(*again == *manifest, "changed by a round trip");
  return 0;
}
