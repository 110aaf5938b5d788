#include "detail/photo_file.h"

#include <algorithm>
#include <cstring>
#include <memory>

#include <turbojpeg.h>

#include "core/file.h"
#include "core/png.h"
#include "core/text.h"
#include "core/working_on.h"
#include "detail/exif_orientation.h"
#include "detail/tiff_file.h"

namespace floatstage::detail {
namespace {

constexpr std::int64_t kMostPixels = 256'000'000;
constexpr std::int64_t kSmall = 1'000'000;  // px; whose memory is nobody's concern

Result<void> check_size(std::int64_t width, std::int64_t height, std::string_view name) {
  if (width < 1 || height < 1) return fail(ErrorCode::BadData, text(name, ": a picture without pixels"));
  if (width <= kMostPixels / height) return {};  // their product may have more than 63 bits
  return fail(ErrorCode::Unsupported, text(name, ": ", width, "x", height, " px are more than ",
                                           kMostPixels / 1'000'000, " million; make it smaller first"));
}

struct Destroy {
  void operator()(void* handle) const { tjDestroy(handle); }
};

// As Adobe's programs write it: 255 is no ink.
Image rgb_of_cmyk(const Image& cmyk) {
  Image rgb(cmyk.width, cmyk.height, 3);
  for (std::size_t i = 0, n = rgb.pixels.size() / 3; i < n; ++i)
    for (std::size_t c = 0; c < 3; ++c)
      rgb.pixels[3 * i + c] =
          static_cast<std::uint8_t>((cmyk.pixels[4 * i + c] * cmyk.pixels[4 * i + 3] + 127) / 255);
  return rgb;
}

Result<Image> decode_jpeg_photo(std::string_view jpeg, std::string_view name) {
  const std::unique_ptr<void, Destroy> handle(tjInitDecompress());
  FLOATSTAGE_CHECK(handle, "libturbojpeg has no memory");
  const auto* bytes = reinterpret_cast<const unsigned char*>(jpeg.data());
  int width = 0, height = 0, sampling = 0, space = 0;
  if (tjDecompressHeader3(handle.get(), bytes, jpeg.size(), &width, &height, &sampling, &space) != 0)
    return fail(ErrorCode::BadData,
                text(name, ": no JPEG that can be read (", tjGetErrorStr2(handle.get()), ")"));
  if (Result<void> ok = check_size(width, height, name); !ok) return forward(ok);
  // Each block of 8x8 px has a bit of its own at least: fewer bytes hold no such picture.
  if (std::int64_t{width} * height > kSmall && static_cast<std::size_t>(width) * height / 512 > jpeg.size())
    return fail(ErrorCode::BadData,
                text(name, ": no JPEG of ", width, "x", height, " px has ", jpeg.size(), " bytes only"));
  const bool inks = space == TJCS_CMYK || space == TJCS_YCCK;
  Image picture(width, height, inks ? 4 : 3);
  // A warning leaves grey where the bytes ended: damaged, as much as an error.
  if (tjDecompress2(handle.get(), bytes, jpeg.size(), picture.pixels.data(), width, 0, height,
                    inks ? TJPF_CMYK : TJPF_RGB, TJFLAG_STOPONWARNING) != 0)
    return fail(ErrorCode::BadData, text(name, ": a damaged JPEG (", tjGetErrorStr2(handle.get()), ")"));
  return inks ? rgb_of_cmyk(picture) : picture;
}

std::int64_t big_endian(std::string_view bytes, std::size_t at) {
  std::int64_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
  return value;
}

Result<Image> decode_png_photo(std::string_view bytes, std::string_view name) {
  if (bytes.size() >= 24)  // before memory is taken for it
    if (Result<void> ok = check_size(big_endian(bytes, 16), big_endian(bytes, 20), name); !ok)
      return forward(ok);
  Result<Image> png = decode_png({reinterpret_cast<const std::byte*>(bytes.data()), bytes.size()}, name);
  if (!png || png->channels == 3) return png;
  Image rgb(png->width, png->height, 3);
  const auto channels = static_cast<std::size_t>(png->channels);
  for (std::size_t i = 0, n = rgb.pixels.size() / 3; i < n; ++i)
    for (std::size_t c = 0; c < 3; ++c)
      rgb.pixels[3 * i + c] = png->pixels[i * channels + (channels == 4 ? c : 0)];
  return rgb;
}

}  // namespace

bool has_name_of_photo(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending == ".jpg" || ending == ".jpeg" || ending == ".png" || ending == ".tif" || ending == ".tiff";
}

Result<Image> decode_photo(std::string_view bytes, std::string_view name) {
  const WorkingOn here(name);
  if (bytes.empty()) return fail(ErrorCode::BadData, text(name, " is empty"));
  Result<Image> picture = Image();
  if (bytes.starts_with("\xFF\xD8")) {
    picture = decode_jpeg_photo(bytes, name);
  } else if (bytes.starts_with("\x89PNG")) {
    picture = decode_png_photo(bytes, name);
  } else if (is_tiff(bytes)) {
    picture = decode_tiff(bytes, kMostPixels, name);
  } else {
    return fail(ErrorCode::Unsupported, text(name, " is neither a JPEG nor a PNG nor a TIFF"));
  }
  if (!picture) return picture;
  return upright(std::move(*picture), exif_orientation(bytes));
}

Result<Image> load_photo(const std::filesystem::path& file) {
  const Result<std::string> bytes = read_file(file);
  if (!bytes) return forward(bytes);
  return decode_photo(*bytes, file.string());
}

}  // namespace floatstage::detail
