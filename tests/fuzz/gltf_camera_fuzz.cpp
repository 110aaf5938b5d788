#include <cstdint>
#include <string_view>

#include "core/check.h"
#include "pipeline/import/gltf_camera.h"

// A .gltf or .glb with an animated camera. Buffers in files of their own are tests' (PathFiles): there is no
// folder.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  const auto cameras = pipeline::parse_gltf_camera({reinterpret_cast<const char*>(data), size}, "fuzz",
                                                   "/no/such/folder", false, "");
  if (!cameras) return 0;
  for (const pipeline::FilmCamera& camera : *cameras)
    FLOATSTAGE_CHECK(camera.cam_from_world.matrix().allFinite(), "a camera that is nowhere");
  return 0;
}
