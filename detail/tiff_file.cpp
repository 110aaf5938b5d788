#include "detail/tiff_file.h"

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <mutex>
#include <new>

#include <tiffio.h>

#include "core/text.h"
#include "detail/tiff_complaints.h"

namespace floatstage::detail {
namespace {

constexpr std::uint64_t kSlack = 1'000'000;  // bytes, whose memory is nobody's concern

/// A file in memory, as libtiff's callbacks want it.
struct Bytes : TiffHandle {
  explicit Bytes(std::string_view all) : bytes(all) {}
  std::string_view bytes;
  std::uint64_t at = 0;
};

Bytes& bytes_of(thandle_t handle) { return static_cast<Bytes&>(*static_cast<TiffHandle*>(handle)); }

tmsize_t read(thandle_t handle, void* to, tmsize_t size) {
  Bytes& file = bytes_of(handle);
  if (size < 0 || file.at >= file.bytes.size()) return 0;
  const std::size_t n = std::min<std::size_t>(static_cast<std::size_t>(size), file.bytes.size() - file.at);
  std::memcpy(to, file.bytes.data() + file.at, n);
  file.at += n;
  return static_cast<tmsize_t>(n);
}

tmsize_t write(thandle_t, void*, tmsize_t) { return 0; }

toff_t seek(thandle_t handle, toff_t offset, int whence) {
  Bytes& file = bytes_of(handle);
  if (whence == SEEK_SET) file.at = offset;
  if (whence == SEEK_CUR) file.at += offset;
  if (whence == SEEK_END) file.at = file.bytes.size() + offset;
  return file.at;
}

int close(thandle_t) { return 0; }
toff_t size(thandle_t handle) { return bytes_of(handle).bytes.size(); }

void keep(thandle_t handle, const char*, const char* format, va_list words) {
  char sentence[300];
  std::vsnprintf(sentence, sizeof sentence, format, words);
  if (handle == nullptr) return;
  if (std::string& first = static_cast<TiffHandle*>(handle)->complaint; first.empty()) first = sentence;
}

struct Free {
  void operator()(std::uint32_t* raster) const { std::free(raster); }
};

struct Close {
  void operator()(TIFF* tiff) const { TIFFClose(tiff); }
};

std::uint16_t coding_of(TIFF* tiff) {
  std::uint16_t compression = COMPRESSION_NONE;
  TIFFGetFieldDefaulted(tiff, TIFFTAG_COMPRESSION, &compression);
  return compression;
}

/// The most bytes that one of the file can stand for; 0 where there is no such number (a row of nothing but
/// white has one bit in fax machines' codes, however long it is).
std::uint64_t most_bytes_of_one(TIFF* tiff) {
  switch (coding_of(tiff)) {
    case COMPRESSION_NONE:
      return 1;
    case COMPRESSION_PACKBITS:
      return 64;  // two bytes for 128
    case COMPRESSION_LZW:
      return 4096;  // its table's entries have no more bytes, and a code has nine bits or more
    case COMPRESSION_DEFLATE:
    case COMPRESSION_ADOBE_DEFLATE:
      return 1032;
    case COMPRESSION_JPEG:
      return 3 * 512;  // a bit for a block of 64 px
    default:
      return 0;
  }
}

bool can_hold_it(TIFF* tiff, std::uint64_t bytes, std::uint32_t height) {
  const std::uint64_t most = most_bytes_of_one(tiff);
  return most == 0 || TIFFRasterScanlineSize64(tiff) * height / most <= bytes + kSlack;
}

}  // namespace

void keep_complaints() {
  static std::once_flag once;
  std::call_once(once, [] {
    TIFFSetErrorHandler(nullptr);
    TIFFSetWarningHandler(nullptr);
    TIFFSetErrorHandlerExt(keep);
  });
}

bool is_tiff(std::string_view bytes) {
  for (const char* magic : {"II*\0", "MM\0*", "II+\0", "MM\0+"})
    if (bytes.starts_with(std::string_view(magic, 4))) return true;
  return false;
}

Result<Image> decode_tiff(std::string_view bytes, std::int64_t most_pixels, std::string_view name) {
  keep_complaints();
  Bytes file(bytes);
  const auto bad = [&](const char* what) {
    return fail(ErrorCode::BadData, text(name, ": ", what, file.complaint.empty() ? "" : " (", file.complaint,
                                         file.complaint.empty() ? "" : ")"));
  };
  // "rm": nothing is mapped; all goes through read().
  const std::unique_ptr<TIFF, Close> tiff(TIFFClientOpen("photograph", "rm", static_cast<TiffHandle*>(&file),
                                                         read, write, seek, close, size, nullptr, nullptr));
  if (!tiff) return bad("no TIFF that can be read");
  std::uint32_t width = 0, height = 0;
  std::uint16_t stored = ORIENTATION_TOPLEFT;
  if (TIFFGetField(tiff.get(), TIFFTAG_IMAGEWIDTH, &width) != 1 ||
      TIFFGetField(tiff.get(), TIFFTAG_IMAGELENGTH, &height) != 1 || width == 0 || height == 0)
    return bad("a TIFF without a size");
  if (std::uint64_t{width} * height > static_cast<std::uint64_t>(most_pixels))
    return fail(ErrorCode::Unsupported, text(name, ": ", width, "x", height, " px are more than ",
                                             most_pixels / 1'000'000, " million; make it smaller first"));
  if (const std::uint16_t coding = coding_of(tiff.get()); TIFFIsCODECConfigured(coding) == 0)
    return fail(ErrorCode::Unsupported, text(name, ": a TIFF of a coding that is not read (", coding, ")"));
  if (!can_hold_it(tiff.get(), bytes.size(), height)) return bad("a TIFF far shorter than its picture");
  char why[1024] = "";
  if (TIFFRGBAImageOK(tiff.get(), why) != 1)
    return fail(ErrorCode::Unsupported, text(name, ": a TIFF of a kind that is not read (", why, ")"));
  TIFFGetFieldDefaulted(tiff.get(), TIFFTAG_ORIENTATION, &stored);
  // Its pages are there once they are written: a file of an unknown coding or a few bytes writes none.
  const std::size_t pixels = static_cast<std::size_t>(width) * height;
  const std::unique_ptr<std::uint32_t, Free> raster(
      static_cast<std::uint32_t*>(std::calloc(pixels, sizeof(std::uint32_t))));
  if (!raster) throw std::bad_alloc();
  // Asked for as it is stored, libtiff turns nothing.
  if (TIFFReadRGBAImageOriented(tiff.get(), width, height, raster.get(), stored, 1) != 1)
    return bad("a damaged TIFF");
  Image rgb(static_cast<int>(width), static_cast<int>(height), 3);
  for (std::size_t i = 0; i < pixels; ++i) {
    const std::uint32_t pixel = raster.get()[i];
    rgb.pixels[3 * i] = static_cast<std::uint8_t>(TIFFGetR(pixel));
    rgb.pixels[3 * i + 1] = static_cast<std::uint8_t>(TIFFGetG(pixel));
    rgb.pixels[3 * i + 2] = static_cast<std::uint8_t>(TIFFGetB(pixel));
  }
  return rgb;
}

}  // namespace floatstage::detail
