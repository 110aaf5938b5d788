#include "core/png.h"

#include <csetjmp>
#include <cstdint>
#include <cstring>
#include <vector>

#include <png.h>
#include <zlib.h>

#include "core/file.h"
#include "core/text.h"
#include "core/working_on.h"

namespace floatstage {
namespace {

// libpng reports by longjmp; these frames hold only trivially destructible objects below the setjmp.
struct WriteState {
  std::string* out;
};

void append_bytes(png_structp png, png_bytep data, png_size_t size) {
  static_cast<WriteState*>(png_get_io_ptr(png))->out->append(reinterpret_cast<const char*>(data), size);
}

struct Packing {
  int level;          // zlib's
  int filter = -1;    // one of libpng's; -1: the best of each row, which costs as much again as packing
  bool runs = false;  // nothing but runs of equal bytes is looked for
};

// `rows`: the samples, of 8 or 16 bits (big-endian).
bool encode(const Image& image, const std::uint8_t* rows, int bits, Packing packing, std::string& out) {
  png_structp png =
      png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, [](png_structp, png_const_charp) {});
  png_infop info = png ? png_create_info_struct(png) : nullptr;
  WriteState state{&out};
  if (!info || setjmp(png_jmpbuf(png))) {
    png_destroy_write_struct(&png, &info);
    return false;
  }
  png_set_write_fn(png, &state, append_bytes, nullptr);
  const int type = image.channels == 1   ? PNG_COLOR_TYPE_GRAY
                   : image.channels == 3 ? PNG_COLOR_TYPE_RGB
                                         : PNG_COLOR_TYPE_RGBA;
  png_set_IHDR(png, info, static_cast<png_uint_32>(image.width), static_cast<png_uint_32>(image.height), bits,
               type, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_compression_level(png, packing.level);
  if (packing.filter >= 0) png_set_filter(png, PNG_FILTER_TYPE_BASE, packing.filter);
  if (packing.runs) png_set_compression_strategy(png, Z_RLE);
  png_write_info(png, info);
  const std::size_t row =
      static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.channels * bits / 8);
  for (int y = 0; y < image.height; ++y) png_write_row(png, rows + static_cast<std::size_t>(y) * row);
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  return true;
}

}  // namespace

Result<Image> load_png(const std::filesystem::path& file) {
  const Result<std::string> bytes = read_file(file);
  if (!bytes) return forward(bytes);
  return decode_png(std::as_bytes(std::span(*bytes)), file.string());
}

Result<Image> decode_png(std::span<const std::byte> bytes, std::string_view name) {
  const WorkingOn here(name);
  png_image header;
  std::memset(&header, 0, sizeof header);
  header.version = PNG_IMAGE_VERSION;
  auto bad = [&](const char* what) {
    png_image_free(&header);
    return fail(ErrorCode::BadData, text(name, ": ", what, "; the file is not a whole PNG"));
  };
  if (!png_image_begin_read_from_memory(&header, bytes.data(), bytes.size())) return bad(header.message);
  constexpr png_uint_32 kLargest = 1u << 15;
  if (header.width > kLargest || header.height > kLargest) return bad("larger than 32768 px");
  // Deflate packs at most 1032 to 1 and a pixel has at least one bit: a small file that claims more has no
  // such data.
  if (header.width / 8 * std::uint64_t{header.height} > std::uint64_t{1032} * bytes.size())
    return bad("far shorter than its picture");
  if (header.width * std::uint64_t{header.height} > kMostPngPixels) return bad("more than 112 Mpx");
  header.flags |=
      PNG_IMAGE_FLAG_16BIT_sRGB;  // libpng takes 16 bits for linear light where the file does not say
  const bool color = header.format & PNG_FORMAT_FLAG_COLOR, alpha = header.format & PNG_FORMAT_FLAG_ALPHA;
  header.format = alpha ? PNG_FORMAT_RGBA : color ? PNG_FORMAT_RGB : PNG_FORMAT_GRAY;
  Image image(static_cast<int>(header.width), static_cast<int>(header.height), alpha ? 4 : color ? 3 : 1);
  if (!png_image_finish_read(&header, nullptr, image.pixels.data(), 0, nullptr)) return bad(header.message);
  return image;
}

namespace {

void check_image(const Image& image) {
  FLOATSTAGE_CHECK(!image.empty() && (image.channels == 1 || image.channels == 3 || image.channels == 4),
                   text("a PNG of ", image.width, "x", image.height, "x", image.channels));
}

Result<void> save(const Image& image, const std::uint8_t* rows, int bits, const std::filesystem::path& file,
                  Packing packing) {
  check_image(image);
  std::string bytes;
  if (!encode(image, rows, bits, packing, bytes))
    return fail(ErrorCode::Io, text("cannot encode ", file.string(), " as PNG"));
  return write_file(file, bytes);
}

}  // namespace

// Photographs and renders are a tenth smaller as runs of what is left of the Paeth filter than with matches
// looked for after the best of all filters, in half the time (ADR 361).
Result<void> save_png(const Image& image, const std::filesystem::path& file) {
  return save(image, image.pixels.data(), 8, file, {.level = 1, .filter = PNG_FILTER_PAETH, .runs = true});
}

Result<std::string> encode_png_of_runs(const Image& image) {
  check_image(image);
  std::string bytes;
  if (!encode(image, image.pixels.data(), 8, {.level = 1, .filter = PNG_FILTER_NONE, .runs = true}, bytes))
    return fail(ErrorCode::Io, text("cannot encode a PNG of ", image.width, "x", image.height));
  return bytes;
}

Result<void> save_png16(const Image& image, const std::filesystem::path& file) {
  std::vector<std::uint8_t> wide(2 * image.pixels.size());
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    wide[2 * i] = wide[2 * i + 1] = image.pixels[i];  // v * 257
  return save(image, wide.data(), 16, file, {.level = 3});
}

}  // namespace floatstage
