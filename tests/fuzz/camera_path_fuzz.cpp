#include <cstdint>
#include <string_view>

#include "core/check.h"
#include "pipeline/camera_path.h"

// A path.json of the player's.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  const Result<pipeline::CameraPath> path =
      pipeline::parse_path({reinterpret_cast<const char*>(data), size}, "fuzz");
  if (!path) return 0;
  FLOATSTAGE_CHECK(!path->keys.empty(), "a path without keys");
  for (const pipeline::PathKey& key : path->keys)
    FLOATSTAGE_CHECK(key.eye.allFinite() && key.target.allFinite() && key.up.allFinite(),
                     "a key that is nowhere");
  FLOATSTAGE_CHECK(pipeline::parse_path(to_json(*path), "again"), "what we wrote does not parse");
  return 0;
}
