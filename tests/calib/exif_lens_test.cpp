#include "calib/exif_lens.h"

#include <gtest/gtest.h>

namespace floatstage::calib {
namespace {

// A JPEG's head with EXIF: two directories, little endian or big.
class Exif {
 public:
  explicit Exif(bool little) : little_(little) {}
  std::string jpeg(int film_mm, int focal_mm = 0, int pitch = 0, int width = 0) const {
    // Head 8, first directory of 2 entries at 8, EXIF directory behind it, values behind that.
    const int entries = 4, exif = 8 + 2 + 2 * 12 + 4, values = exif + 2 + entries * 12 + 4;
    std::string t =
        std::string(little_ ? "II*" : "MM") + (little_ ? std::string(1, '\0') : std::string("\0*", 2));
    t += number(8, 4) + number(2, 2);
    t += entry(0x0110, 2, 4, "Cam") + std::string();
    t += number(0x8769, 2) + number(4, 2) + number(1, 4) + number(exif, 4) + number(0, 4);
    t += number(entries, 2);
    t += number(0x920A, 2) + number(5, 2) + number(1, 4) + number(values, 4);
    t += number(0xA002, 2) + number(4, 2) + number(1, 4) + number(width, 4);
    t += number(0xA20E, 2) + number(5, 2) + number(1, 4) + number(values + 8, 4);
    t += number(0xA405, 2) + number(3, 2) + number(1, 4) + number(film_mm, 2) + std::string(2, '\0');
    t += number(0, 4) + number(focal_mm, 4) + number(1, 4) + number(pitch, 4) + number(1, 4);
    const std::string body = std::string("Exif\0\0", 6) + t;
    const auto length = body.size() + 2;
    return std::string("\xFF\xD8\xFF\xE1") + static_cast<char>(length >> 8) +
           static_cast<char>(length & 255) + body;
  }

 private:
  std::string number(long value, int bytes) const {
    std::string s;
    for (int i = 0; i < bytes; ++i)
      s += static_cast<char>(value >> (8 * (little_ ? i : bytes - 1 - i)) & 255);
    return s;
  }
  std::string entry(int tag, int type, int count, const char* four) const {
    return number(tag, 2) + number(type, 2) + number(count, 4) + std::string(four, 4);
  }
  bool little_;
};

TEST(ExifLens, TellsTheFocalLengthOf35MillimetreFilm) {
  for (const bool little : {true, false}) {
    const ExifLens lens = exif_lens(Exif(little).jpeg(72));
    ASSERT_TRUE(lens.focal_per_width) << little;
    EXPECT_NEAR(*lens.focal_per_width, 2, 1e-9);
    EXPECT_EQ(lens.camera, "Cam");
  }
}

TEST(ExifLens, TellsItFromTheSensorsPitch) {
  // 8 mm and 2540 pixels an inch (10 µm): 800 px, of a picture 1600 wide.
  const ExifLens lens = exif_lens(Exif(true).jpeg(0, 8, 2540, 1600));
  ASSERT_TRUE(lens.focal_per_width);
  EXPECT_NEAR(*lens.focal_per_width, 0.5, 1e-9);
}

TEST(ExifLens, SaysNothingOfOtherFilesAndSurvivesCutOnes) {
  EXPECT_FALSE(exif_lens("").focal_per_width);
  EXPECT_FALSE(exif_lens("\x89PNG....").focal_per_width);
  EXPECT_FALSE(exif_lens(Exif(true).jpeg(0)).focal_per_width) << "nothing was said";
  const std::string whole = Exif(true).jpeg(50);
  for (std::size_t n = 0; n < whole.size(); ++n) (void)exif_lens(whole.substr(0, n));
}

}  // namespace
}  // namespace floatstage::calib
