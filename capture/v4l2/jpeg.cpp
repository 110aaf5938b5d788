#include "capture/v4l2/jpeg.h"

#include <memory>

#include <turbojpeg.h>

#include "core/check.h"
#include "core/text.h"

namespace floatstage {

namespace {

struct Destroy {
  void operator()(void* handle) const { tjDestroy(handle); }
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

}  // namespace floatstage
