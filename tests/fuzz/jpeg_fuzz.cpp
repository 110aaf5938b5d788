#include <cstdint>
#include <span>

#include "calib/exif_lens.h"
#include "core/check.h"
#include "core/jpeg.h"

// JPEG from cameras and from the network, whose size is known before; and what a photograph says of its lens.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  for (const int side : {8, 16, 24}) {
    const Result<Image> image = decode_jpeg(std::as_bytes(std::span(data, size)), side, side);
    if (!image) continue;
    FLOATSTAGE_CHECK(image->width == side && image->pixels.size() == std::size_t{3} * side * side,
                     "an image of another size than was asked for");
  }
  const calib::ExifLens lens = calib::exif_lens({reinterpret_cast<const char*>(data), size});
  FLOATSTAGE_CHECK(!lens.focal_per_width || *lens.focal_per_width > 0, "a lens that is none");
  return 0;
}
