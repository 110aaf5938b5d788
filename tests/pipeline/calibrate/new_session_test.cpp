// `calibrate new` before made pictures: a clip, and pictures that show little.

#include "pipeline/calibrate/new_session.h"

#include <array>
#include <cmath>
#include <cstdint>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/file.h"
#include "core/png.h"
#include "core/text.h"
#include "pipeline/calibrate/session.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::pipeline {
namespace {

using testing::Contains;
using testing::HasSubstr;

constexpr int kWidth = 320, kHeight = 240, kFrames = 24;

double lattice(int x, int y) {
  std::uint32_t h = static_cast<std::uint32_t>(x) * 374761393U + static_cast<std::uint32_t>(y) * 668265263U;
  h = (h ^ (h >> 13)) * 1274126177U;
  return static_cast<double>((h ^ (h >> 16)) % 1000) / 1000;
}

// Cloud-like, the same at the same place.
double cloud(double x, double y) {
  constexpr double kCell = 6;
  const double u = x / kCell, v = y / kCell;
  const int i = static_cast<int>(std::floor(u)), k = static_cast<int>(std::floor(v));
  const double a = u - i, b = v - k;
  return (1 - b) * ((1 - a) * lattice(i, k) + a * lattice(i + 1, k)) +
         b * ((1 - a) * lattice(i, k + 1) + a * lattice(i + 1, k + 1));
}

// Pictures of five bands, each of which shifts by so many pixels from one picture to the next: things at five
// distances, before a camera that is carried along.
void write_clip(const TempFolder& folder, const std::array<double, 5>& shifts, double contrast = 200) {
  ASSERT_THAT(make_folder(folder / "clip"), IsOk());
  for (int f = 0; f < kFrames; ++f) {
    Image picture(kWidth, kHeight, 1);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const double shift = f * shifts[static_cast<std::size_t>(5 * y / kHeight)];
        *picture.at(x, y) = static_cast<std::uint8_t>(std::lround(20 + contrast * cloud(x + shift, y)));
      }
    ASSERT_THAT(save_png(picture, folder / text("clip/", 100 + f, ".png")), IsOk());
  }
}

TEST(NewSessionOfAClip, TakesSomeOfItsPicturesAndOneLens) {
  const TempFolder folder;
  write_clip(folder, {0, 2, 0.5, 1.6, 1});
  const Result<NewSession> drafted = draft_session(folder / "clip", folder.path(), {});
  ASSERT_THAT(drafted, IsOk());
  EXPECT_EQ(drafted->cameras, 12u);
  EXPECT_THAT(drafted->found, Contains(HasSubstr("24 pictures in")));
  EXPECT_THAT(drafted->toml, HasSubstr("lens = \"shared\""));
  const Result<Session> session = parse_session(drafted->toml, "session.toml");
  ASSERT_THAT(session, IsOk());
  EXPECT_EQ(session->cameras.size(), 12u);
}

TEST(NewSessionOfAClip, OfACameraThatOnlyTurnedIsRefusedWithWhatToDo) {
  const TempFolder folder;
  write_clip(folder, {1, 1, 1, 1, 1});
  EXPECT_THAT(draft_session(folder / "clip", folder.path(), {}),
              FailsWith(ErrorCode::BadData, "its camera hardly left its place"));
}

TEST(NewSessionOfAScene, OfPicturesThatHaveNothingInCommonIsRefused) {
  const TempFolder folder;
  ASSERT_THAT(make_folder(folder / "mixed"), IsOk());
  for (int f = 0; f < 8; ++f) {
    Image picture(kWidth, kHeight, 1);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        *picture.at(x, y) = static_cast<std::uint8_t>(std::lround(20 + 200 * cloud(x + 5000 * f, y)));
    ASSERT_THAT(save_png(picture, folder / text("mixed/", f, ".png")), IsOk());
  }
  EXPECT_THAT(draft_session(folder / "mixed", folder.path(), {}),
              FailsWith(ErrorCode::BadData, "show no common scene"));
}

TEST(NewSessionOfAScene, WhoseSurfacesAreBareLooksForFainterPoints) {
  for (const auto& [contrast, asked] : {std::pair(200.0, false), {6.0, true}}) {
    const TempFolder folder;
    write_clip(folder, {12, 9, 14, 7, 11}, contrast);  // too far from one to the next for a clip
    const Result<NewSession> drafted = draft_session(folder / "clip", folder.path(), {});
    ASSERT_THAT(drafted, IsOk());
    EXPECT_EQ(drafted->cameras, static_cast<std::size_t>(kFrames));
    const Result<Session> session = parse_session(drafted->toml, "session.toml");
    ASSERT_THAT(session, IsOk());
    EXPECT_EQ(session->markerless->contrast < calib::kUsualContrast, asked) << drafted->toml;
  }
}

}  // namespace
}  // namespace floatstage::pipeline
