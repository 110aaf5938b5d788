#include <cstdint>
#include <string>

#include "core/check.h"
#include "matting/spectral/spectral_cache.h"

// A file of matting components either is refused or has the columns that its header promises. The checksum,
// which no mutation would ever meet, is set right first.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  std::string bytes(reinterpret_cast<const char*>(data), size);
  std::uint64_t key = 0;
  for (int pass = 0; pass < 2; ++pass) {
    const auto pairs = matting::parse_eigenpairs(bytes, key, "fuzz");
    if (pairs) FLOATSTAGE_CHECK(pairs->vectors.cols() == pairs->values.size(), "columns and values differ");
    const auto components = matting::parse_components(bytes, key, "fuzz");
    if (components)
      FLOATSTAGE_CHECK(
          components->alpha.rows() == static_cast<Eigen::Index>(components->width) * components->height,
          "rows");
    if (size < 8) return 0;
    const std::uint64_t hash = matting::hash_of(std::string_view(bytes).substr(0, size - 8));
    bytes.replace(size - 8, 8, reinterpret_cast<const char*>(&hash), 8);
  }
  return 0;
}
