#include <cstdint>
#include <string_view>

#include "core/check.h"
#include "detail/exif_orientation.h"
#include "detail/photo_file.h"

// Photographs: JPEG, PNG and TIFF with their EXIF.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  const int turned = detail::exif_orientation(bytes);
  FLOATSTAGE_CHECK(turned >= 1 && turned <= 8, "an orientation that there is not");
  const Result<Image> image = detail::decode_photo(bytes, "fuzz");
  if (!image) return 0;
  const std::size_t expected = static_cast<std::size_t>(image->width) * image->height * 3;
  FLOATSTAGE_CHECK(expected > 0 && image->pixels.size() == expected, "an image of another size than it says");
  return 0;
}
