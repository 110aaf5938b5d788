#include <cstdlib>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "core/png.h"
#include "core/text.h"
#include "matting/keyers/keyer.h"
#include "tests/support/real_data.h"

namespace floatstage::matting {
namespace {

TEST(ChromaKeyerOnTheGreenDome, AgreesWithTheGivenMattesWithoutPlateOrParameter) {
  FLOATSTAGE_NEEDS_DATA(real_data("green-dome"));
  double sum = 0, worst = 1;
  for (int camera = 0; camera < 20; ++camera) {
    const std::string name = text(camera < 10 ? "0" : "", camera, ".png");
    const auto photograph = load_png(real_data("green-dome/images") / name),
               given = load_png(real_data("green-dome/mattes") / name);
    ASSERT_TRUE(photograph && given) << name;
    const auto keyer = make_keyer("chroma", {*photograph});
    ASSERT_TRUE(keyer) << keyer.error().message;
    const auto matte = (*keyer)->key(make_frame({}, *photograph));
    ASSERT_TRUE(matte) << matte.error().message;
    const double agreement = iou(*matte, make_matte({}, *given));
    EXPECT_GE(agreement, 0.95) << name;
    worst = std::min(worst, agreement);
    sum += agreement;
  }
  RecordProperty("mean_iou", text(sum / 20));
  std::cout << "mean IoU " << sum / 20 << ", worst " << worst << "\n";
  EXPECT_GE(sum / 20, 0.975);
}

// A view's matte by a luminance key; empty where a check has failed. Of the 640x480 pictures the temple
// covers between these shares, in every view (bounds found by eye on the mattes), and stands clear of the
// picture's sides; the grey cloth under it does not.
Image temple_matte(const Image& photograph, const std::string& spec, int view) {
  const auto keyer = make_keyer(spec, {photograph});
  EXPECT_TRUE(keyer) << view;
  if (!keyer) return {};
  const auto matte = (*keyer)->key(make_frame({}, photograph));
  EXPECT_TRUE(matte) << view;
  if (!matte) return {};
  EXPECT_GT(coverage(*matte), 0.18) << view;
  EXPECT_LT(coverage(*matte), 0.33) << view;
  Image alpha = to_image(*matte);
  for (int y = 0; y < alpha.height; ++y) {
    EXPECT_EQ(*alpha.at(0, y), 0) << view;
    EXPECT_EQ(*alpha.at(alpha.width - 1, y), 0) << view;
  }
  return alpha;
}

TEST(LuminanceKeyerOnTheTemple, CutsTheTempleOutInOnePiece) {
  const auto folder = real_data("middlebury-temple-ring");
  FLOATSTAGE_NEEDS_DATA(folder);
  int views = 0;
  for (int view = 13; view <= 31; ++view, ++views) {
    const auto photograph = load_png(folder / text("templeR00", view, ".png"));
    ASSERT_TRUE(photograph) << view;
    const Image alpha = temple_matte(*photograph, "luminance:12", view);
    ASSERT_FALSE(alpha.empty());
    int dark = 0, subject = 0;
    for (int y = 0; y < alpha.height; ++y)
      for (int x = 0; x < alpha.width; ++x) {
        subject += *alpha.at(x, y) >= 128;
        dark += *alpha.at(x, y) >= 128 && photograph->at(x, y)[1] <= 12;
      }
    EXPECT_LT(dark, 0.03 * subject) << view;
  }
  EXPECT_EQ(views, 19);
}

// Without a number the shaded inside between the columns counts as temple, too: how dark it may be is not
// asked here.
TEST(LuminanceKeyerOnTheTemple, NeedsNoNumberToTellItFromTheLitClothUnderIt) {
  const auto folder = real_data("middlebury-temple-ring");
  FLOATSTAGE_NEEDS_DATA(folder);
  for (int view = 13; view <= 31; view += 3) {
    const auto photograph = load_png(folder / text("templeR00", view, ".png"));
    ASSERT_TRUE(photograph) << view;
    ASSERT_FALSE(temple_matte(*photograph, "luminance", view).empty());
  }
}

// A plain threshold keys the dinosaur; lit cloth hangs at the pictures' borders, and so does the dinosaur in
// some. 15 of 48 mattes once kept a crescent of it.
TEST(LuminanceKeyerOnTheDinosaur, KeepsItWholeBeforeClothThatCatchesLight) {
  const auto folder = real_data("middlebury-dino-sparse-ring");
  FLOATSTAGE_NEEDS_DATA(folder);
  for (int view = 1; view <= 16; ++view) {
    const auto photograph = load_png(folder / text("dinoSR00", view < 10 ? "0" : "", view, ".png"));
    ASSERT_TRUE(photograph) << view;
    const auto keyer = make_keyer("luminance", {*photograph});
    ASSERT_TRUE(keyer);
    const auto matte = (*keyer)->key(make_frame({}, *photograph));
    ASSERT_TRUE(matte);
    int lit = 0, kept = 0, subject = 0;
    for (int y = 0; y < matte->height; ++y)
      for (int x = 0; x < matte->width; ++x) {
        const bool plaster =
            photograph->at(x, y)[1] > 48;  // no cloth is as bright; some shaded plaster is darker
        lit += plaster;
        kept += plaster && matte->row(y)[x] >= 128;
        subject += matte->row(y)[x] >= 128;
      }
    EXPECT_GE(kept, 0.985 * lit) << view;
    EXPECT_LE(subject, 1.2 * lit) << view;
  }
}

// Green floor, black walls with lamps. 0.95 and 0.90 are wanted; black hair and things at the walls' foot are
// what is missing (docs/matting.md).
TEST(ChromaKeyerBeforeBlackWalls, LearnsThemFromOnePicture) {
  const auto folder = real_data("green-dome-wd");
  FLOATSTAGE_NEEDS_DATA(folder);
  double sum = 0;
  for (int camera = 0; camera < 20; ++camera) {
    const std::string name = text(camera < 10 ? "0" : "", camera, ".png");
    const auto photograph = load_png(folder / "images" / name), given = load_png(folder / "mattes" / name);
    ASSERT_TRUE(photograph && given) << name;
    const auto keyer = make_keyer("chroma", {*photograph});
    ASSERT_TRUE(keyer) << keyer.error().message;
    const auto matte = (*keyer)->key(make_frame({}, *photograph));
    ASSERT_TRUE(matte) << matte.error().message;
    const double agreement = iou(*matte, make_matte({}, *given));
    EXPECT_GE(agreement, 0.87) << name;
    sum += agreement;
  }
  EXPECT_GE(sum / 20, 0.93);
}

}  // namespace
}  // namespace floatstage::matting
