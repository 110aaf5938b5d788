#include <cstdint>
#include <span>

#include "core/check.h"
#include "core/mesh_io.h"

// Whatever parses can be used: finite positions, whole triangles, indices in range.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  const Result<Mesh> mesh = parse_ply(std::as_bytes(std::span(data, size)), "fuzz");
  if (!mesh) return 0;
  FLOATSTAGE_CHECK(mesh->triangles.size() % 3 == 0, "a third of a triangle");
  for (std::uint32_t i : mesh->triangles)
    FLOATSTAGE_CHECK(i < mesh->positions.size(), "an index out of range");
  for (const Eigen::Vector3f& p : mesh->positions)
    FLOATSTAGE_CHECK(p.allFinite(), "a position that is not finite");
  return 0;
}
