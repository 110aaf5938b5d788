#include <cstdint>
#include <span>

#include "core/check.h"
#include "core/png.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  const Result<Image> image = decode_png(std::as_bytes(std::span(data, size)), "fuzz");
  if (!image) return 0;
  const std::size_t expected = static_cast<std::size_t>(image->width) * image->height * image->channels;
  FLOATSTAGE_CHECK(image->pixels.size() == expected, "an image of another size than it says");
  return 0;
}
