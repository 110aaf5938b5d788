#include "tests/hostile/traps.h"

#include <cctype>

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <zlib.h>

#include "core/file.h"
#include "core/image.h"
#include "core/jpeg.h"
#include "core/png.h"
#include "core/text.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage {
namespace {

namespace fs = std::filesystem;

void put(const fs::path& file, const std::string& bytes) { ASSERT_THAT(write_file(file, bytes), IsOk()); }

std::string with_numbers_replaced(std::string bytes, const std::string& by) {
  std::string out;
  bool in_word = false;
  for (std::size_t i = 0; i < bytes.size();) {
    const bool digit = std::isdigit(static_cast<unsigned char>(bytes[i])) != 0;
    if (digit && !in_word) {
      while (i < bytes.size() && (std::isdigit(static_cast<unsigned char>(bytes[i])) || bytes[i] == '.')) ++i;
      out += by;
      continue;
    }
    in_word = std::isalnum(static_cast<unsigned char>(bytes[i])) || bytes[i] == '_';
    out += bytes[i++];
  }
  return out;
}

// Numbers of four bytes, the highest first.
std::string four(std::uint32_t n) {
  return {static_cast<char>(n >> 24), static_cast<char>(n >> 16), static_cast<char>(n >> 8),
          static_cast<char>(n)};
}

// A PNG whose header says another size, with its checksum set right.
std::string resized(std::string png, std::uint32_t width, std::uint32_t height) {
  png.replace(16, 8, four(width) + four(height));
  const auto* const header = reinterpret_cast<const Bytef*>(png.data()) + 12;
  return png.replace(29, 4, four(static_cast<std::uint32_t>(::crc32(0, header, 17))));
}

// As small as can be.
std::string png_of(const Image& image) { return encode_png_of_runs(image).value(); }

std::string jpeg_claiming(std::uint16_t width, std::uint16_t height) {
  std::string jpeg = encode_jpeg(Image(16, 16, 3), 90);
  const std::size_t frame = jpeg.find("\xff\xc0");
  const auto low = [](std::uint16_t n) { return static_cast<char>(n & 255); };
  return jpeg.replace(
      frame + 5, 4, {static_cast<char>(height >> 8), low(height), static_cast<char>(width >> 8), low(width)});
}

}  // namespace

std::string tiff_claiming(std::uint32_t width, std::uint32_t height, std::uint32_t strip_at,
                          std::uint32_t strip_bytes, std::uint32_t coding) {
  std::string tiff = "MM" + std::string("\0\x2a", 2) + four(8) + std::string("\0\x09", 2);
  const auto entry = [&](std::uint32_t tag, std::uint32_t value) {
    tiff += four(tag << 16 | 4) + four(1) + four(value);  // LONG
  };
  entry(256, width), entry(257, height), entry(258, 8), entry(259, coding), entry(262, 1),
      entry(273, strip_at);
  entry(277, 1), entry(278, height), entry(279, strip_bytes);
  return tiff + four(0);
}

const std::vector<Trap>& traps() {
  static const std::vector<Trap> kTraps = {
      {"empty", [](const fs::path& f, const std::string&) { put(f, ""); }},
      {"cut", [](const fs::path& f, const std::string& was) { put(f, was.substr(0, was.size() / 2)); }},
      {"doubled", [](const fs::path& f, const std::string& was) { put(f, was + was); }},
      {"noise",
       [](const fs::path& f, const std::string& was) {
         std::string noise(was.size() + 64, '\0');
         std::uint32_t state = 12345;
         for (char& c : noise) c = static_cast<char>((state = state * 1664525 + 1013904223) >> 24);
         put(f, noise);
       }},
      {"zeros", [](const fs::path& f, const std::string& was) { put(f, std::string(was.size(), '\0')); }},
      {"brackets", [](const fs::path& f, const std::string&) { put(f, std::string(2'000'000, '[')); }},
      {"huge numbers",
       [](const fs::path& f, const std::string& was) { put(f, with_numbers_replaced(was, "9e307")); }},
      {"many numbers",
       [](const fs::path& f, const std::string& was) { put(f, with_numbers_replaced(was, "2147483647")); }},
      {"negative numbers",
       [](const fs::path& f, const std::string& was) { put(f, with_numbers_replaced(was, "-1")); }},
      {"sparse",
       [](const fs::path& f, const std::string& was) {
         put(f, was);
         fs::resize_file(f, std::uintmax_t{64} << 30);
       }},
      {"a pipe",
       [](const fs::path& f, const std::string&) {
         fs::remove(f);
         ASSERT_EQ(::mkfifo(f.c_str(), 0600), 0);
       }},
      {"a device",
       [](const fs::path& f, const std::string&) {
         fs::remove(f);
         fs::create_symlink("/dev/zero", f);
       }},
      {"a folder",
       [](const fs::path& f, const std::string&) {
         fs::remove(f);
         fs::create_directory(f);
       }},
      {"a link to itself",
       [](const fs::path& f, const std::string&) {
         fs::remove(f);
         fs::create_symlink(f.filename(), f);
       }},
      {"gone", [](const fs::path& f, const std::string&) { fs::remove(f); }},
  };
  return kTraps;
}

const std::vector<Bomb>& media_bombs() {
  static const std::vector<Bomb> kBombs = [] {
    const std::string small = png_of(Image(16, 16, 3));
    std::vector<Bomb> bombs = {
        {"PNG of a thousand million pixels", resized(small, 32767, 32767)},
        {"PNG of 2^62 pixels", resized(small, 0x7fffffff, 0x7fffffff)},
        {"PNG of no pixels", resized(small, 0, 16)},
        {"PNG of 36 million zeros", png_of(Image(6000, 6000, 1))},
        {"JPEG of 65500 x 65500", jpeg_claiming(65500, 65500)},
        {"JPEG of 15900 x 15900 that ends", jpeg_claiming(15900, 15900)},
        {"PNG of 2^64 pixels", resized(small, 0xffffffff, 0xffffffff)},
        {"TIFF of 2^64 pixels", tiff_claiming(0xffffffff, 0xffffffff, 8, 64) + std::string(64, 'x')},
        {"TIFF of 15900 x 15900 of a coding that nobody knows",
         tiff_claiming(15900, 15900, 122, 64, 0xc005) + std::string(64, 'x')},
        {"TIFF of 15900 x 15900 that ends",
         tiff_claiming(15900, 15900, 122, 15900 * 15900) + std::string(64, 'x')},
        {"TIFF of 15900 x 15900 whose strip has a few bytes",
         tiff_claiming(15900, 15900, 122, 64) + std::string(64, 'x')},
        {"JPEG of 8000 x 8000 that ends", jpeg_claiming(8000, 8000)},
        {"TIFF of 2^62 pixels", tiff_claiming(0x7fffffff, 0x7fffffff, 8, 64) + std::string(64, 'x')},
        {"TIFF with its strip beyond the end",
         tiff_claiming(64, 64, 0xfffffff0, 0xffffffff) + std::string(64, 'x')},
        {"TIFF of 30000 x 30000 that ends", tiff_claiming(30000, 30000, 122, 64) + std::string(64, 'x')},
        {"BMP of 30000 x 30000", "BM" + std::string("\xff\xff\xff\x7f\0\0\0\0\x36\0\0\0\x28\0\0\0", 16) +
                                     std::string("\x30\x75\0\0\x30\x75\0\0\1\0\x18\0\0\0\0\0", 16) +
                                     std::string(40, '\0')},
        {"raw video of 30000 x 30000",
         "YUV4MPEG2 W30000 H30000 F25:1 Ip A1:1 C420jpeg\nFRAME\n" + std::string(99, 'x')},
        {"raw video of negative size", "YUV4MPEG2 W-5 H-5 F0:0\nFRAME\n"},
        {"PNM of 30000 x 30000", "P6 30000 30000 255\n" + std::string(99, 'x')},
        {"HLS list that leads to the network",
         "#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\nhttp://127.0.0.1:9/a.ts\n"},
        {"HLS list that leads to a file",
         "#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\nfile:///etc/passwd\n"},
        {"list of films", "ffconcat version 1.0\nfile /etc/passwd\n"},
        {"session description",
         "v=0\no=- 0 0 IN IP4 127.0.0.1\ns=x\nc=IN IP4 127.0.0.1\nt=0 0\nm=video 9 RTP/AVP 96\na=rtpmap:96 "
         "H264/90000\n"},
        {"vector picture with entities",
         "<?xml version=\"1.0\"?><!DOCTYPE svg [<!ENTITY a SYSTEM \"file:///etc/passwd\">]><svg>&a;</svg>"},
    };
    return bombs;
  }();
  return kBombs;
}

}  // namespace floatstage
