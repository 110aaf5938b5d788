#include "core/jpeg.h"

#include <memory>

#include <turbojpeg.h>

#include "core/check.h"
#include "core/text.h"

namespace floatstage {

namespace {

struct Destroy {
  void operator()(void* handle) const { tjDestroy(handle); }
};

struct Free {
  void operator()(unsigned char* bytes) const { tjFree(bytes); }
};

}  // namespace

Result<Image> decode_jpeg(std::span<const std::byte> jpeg, int width, int height) {
  // A decoder that met a truncated picture reads the next one as its rest, so each picture gets its own: 2
  // us.
  const std::unique_ptr<void, Destroy> handle(tjInitDecompress());
  FLOATSTAGE_CHECK(handle, "libturbojpeg has no memory");
  const auto* bytes = reinterpret_cast<const unsigned char*>(jpeg.data());
  int w = 0, h = 0, sampling = 0, space = 0;
  if (tjDecompressHeader3(handle.get(), bytes, jpeg.size(), &w, &h, &sampling, &space) != 0)
    return fail(ErrorCode::BadData, text("no JPEG (", tjGetErrorStr2(handle.get()), ")"));
  if (w != width || h != height)
    return fail(ErrorCode::BadData,
                text("a JPEG of ", w, "x", h, " where ", width, "x", height, " was announced"));
  Image image(width, height, 3);
  // A warning leaves grey where the bytes ended: damaged, as much as an error.
  if (tjDecompress2(handle.get(), bytes, jpeg.size(), image.pixels.data(), width, 0, height, TJPF_RGB,
                    TJFLAG_STOPONWARNING) != 0)
    return fail(ErrorCode::BadData, text("a damaged JPEG (", tjGetErrorStr2(handle.get()), ")"));
  return image;
}

std::string encode_jpeg(const Image& rgb, int quality) {
  FLOATSTAGE_CHECK(rgb.channels == 3 && !rgb.empty(), "a JPEG is made of an RGB picture");
  const std::unique_ptr<void, Destroy> handle(tjInitCompress());
  FLOATSTAGE_CHECK(handle, "libturbojpeg has no memory");
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  const int failed = tjCompress2(handle.get(), rgb.pixels.data(), rgb.width, 0, rgb.height, TJPF_RGB, &bytes,
                                 &size, TJSAMP_444, quality, 0);
  const std::unique_ptr<unsigned char, Free> owned(bytes);
  FLOATSTAGE_CHECK(failed == 0, text("libturbojpeg: ", tjGetErrorStr2(handle.get())));
  return {reinterpret_cast<const char*>(bytes), size};
}

}  // namespace floatstage
