// Method:  the tags of EXIF's two directories that tell a focal
//          length in pixels
// Paper:   CIPA DC-008-2019, "Exchangeable image file format for digital still cameras: Exif 2.32"
// Differs: no table of sensors: without a 35 mm equivalent or a sensor's pitch nothing is said
// ADR:     0228

#include "calib/exif_lens.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace floatstage::calib {
namespace {

enum Tag : std::uint32_t {
  kMake = 0x010F,
  kModel = 0x0110,
  kExifDirectory = 0x8769,
  kFocalLength = 0x920A,   // mm
  kPixelsAcross = 0xA002,  // of the picture as it was taken
  kPixelsDown = 0xA003,
  kPitchAcross = 0xA20E,    // pixels a unit
  kPitchUnit = 0xA210,      // 2 inch, 3 cm
  kFocalLength35 = 0xA405,  // mm
};
constexpr std::size_t kMostEntries = 1000;  // of a directory; a camera writes some forty
constexpr double kFilmWidth = 36;           // mm

// The bytes of a TIFF, which is what EXIF wraps. Reading past the end gives zeros.
class Tiff {
 public:
  explicit Tiff(std::string_view bytes) : bytes_(bytes), little_(bytes.starts_with("II")) {}
  std::uint32_t number(std::size_t at, int size) const {
    std::uint32_t value = 0;
    for (int i = 0; i < size; ++i) {
      const std::size_t where = at + static_cast<std::size_t>(little_ ? size - 1 - i : i);
      value = value << 8 | (where < bytes_.size() ? static_cast<unsigned char>(bytes_[where]) : 0U);
    }
    return value;
  }
  // Where the entry of a tag begins, in a directory; 0 when it is not there.
  std::size_t entry(std::size_t directory, std::uint32_t tag) const {
    const std::size_t entries = std::min<std::size_t>(number(directory, 2), kMostEntries);
    for (std::size_t i = 0; i < entries; ++i)
      if (const std::size_t at = directory + 2 + 12 * i; number(at, 2) == tag) return at;
    return 0;
  }
  // A whole number or a fraction; 0 for what is not there.
  double value(std::size_t directory, std::uint32_t tag) const {
    const std::size_t at = entry(directory, tag);
    if (at == 0) return 0;
    constexpr std::uint32_t kShort = 3, kLong = 4, kRational = 5;
    const std::uint32_t type = number(at + 2, 2);
    if (type == kShort) return number(at + 8, 2);
    if (type == kLong) return number(at + 8, 4);
    if (type != kRational) return 0;
    const std::size_t there = number(at + 8, 4);
    const double below = number(there + 4, 4);
    return below > 0 ? number(there, 4) / below : 0;
  }
  std::string words(std::size_t directory, std::uint32_t tag) const {
    const std::size_t at = entry(directory, tag);
    constexpr std::size_t kMost = 64;
    const std::size_t count = at == 0 ? 0 : number(at + 4, 4);
    const std::size_t there = count > 4 ? number(at + 8, 4) : at + 8;
    std::string out;
    for (std::size_t i = 0; i < std::min(count, kMost) && there + i < bytes_.size(); ++i) {
      const char c = bytes_[there + i];
      if (c == '\0') break;
      out += c >= ' ' && c <= '~' ? c : '?';
    }
    while (out.ends_with(' ')) out.pop_back();
    return out;
  }

 private:
  std::string_view bytes_;
  bool little_;
};

ExifLens of_tiff(const Tiff& tiff) {
  ExifLens out;
  const std::size_t first = tiff.number(4, 4);
  const std::string make = tiff.words(first, kMake), model = tiff.words(first, kModel);
  out.camera = make.empty() || model.starts_with(make) ? model : make + " " + model;
  const auto exif = static_cast<std::size_t>(tiff.value(first, kExifDirectory));
  if (exif == 0) return out;
  const double film = tiff.value(exif, kFocalLength35), focal = tiff.value(exif, kFocalLength);
  const double unit = tiff.value(exif, kPitchUnit) == 3 ? 10 : 25.4;  // mm
  const double across = std::max(tiff.value(exif, kPixelsAcross), tiff.value(exif, kPixelsDown));
  const double pitch = tiff.value(exif, kPitchAcross);
  double share = 0;
  if (film > 0)
    share = film / kFilmWidth;
  else if (focal > 0 && pitch > 0 && across > 0)
    share = focal * pitch / unit / across;
  constexpr double kLeast = 0.1, kMost = 100;  // a wrong unit, not a lens
  if (std::isfinite(share) && share > kLeast && share < kMost) out.focal_per_width = share;
  return out;
}

}  // namespace

ExifLens exif_lens(std::string_view file) {
  if (!file.starts_with("\xFF\xD8")) return {};
  const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(file[at]); };
  for (std::size_t at = 2; at + 4 <= file.size();) {
    const unsigned marker = byte(at + 1), length = byte(at + 2) * 256U + byte(at + 3);
    if (byte(at) != 0xFF || marker == 0xDA || marker == 0xD9 || length < 2) break;  // the picture begins
    const std::string_view segment = file.substr(at + 4, length - 2);
    constexpr std::string_view kHead("Exif\0\0", 6);
    if (marker == 0xE1 && segment.starts_with(kHead)) {
      const std::string_view tiff = segment.substr(kHead.size());
      if (tiff.starts_with(std::string_view("II*\0", 4)) || tiff.starts_with(std::string_view("MM\0*", 4)))
        return of_tiff(Tiff(tiff));
    }
    at += 2 + length;
  }
  return {};
}

}  // namespace floatstage::calib
