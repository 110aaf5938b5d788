#include "render/closed_mesh.h"

#include <cstdint>

namespace floatstage::render {
namespace {

std::uint64_t mixed(std::uint64_t x) {  // the finaliser of MurmurHash3 (Appleby)
  x ^= x >> 33;
  x *= 0xff51afd7ed558ccdULL;
  x ^= x >> 33;
  x *= 0xc4ceb9fe1a85ec53ULL;
  return x ^ (x >> 33);
}

}  // namespace

bool is_closed(const Mesh& mesh) {
  // The sum over directed edges of a hash that changes its sign with the direction is zero for a closed mesh
  // and for no other but with a chance of 2^-64.
  std::uint64_t boundary = 0;
  for (std::size_t t = 0; t + 2 < mesh.triangles.size(); t += 3)
    for (std::size_t e = 0; e < 3; ++e) {
      const std::uint64_t from = mesh.triangles[t + e], to = mesh.triangles[t + (e + 1) % 3];
      if (from < to)
        boundary += mixed(from << 32 | to);
      else if (from > to)
        boundary -= mixed(to << 32 | from);
    }
  return boundary == 0 && signed_volume(mesh) > 0;
}

}  // namespace floatstage::render
