#include "pipeline/matte/matte_image.h"

#include <cmath>

#include "matting/closed_form.h"
#include "matting/pyramid_matte.h"
#include "pipeline/metrics/matte_metrics.h"
#include "tests/matting/pictures.h"
#include "tests/matting/small_scenes.h"
#include "tests/support/matchers.h"

namespace floatstage::pipeline {
namespace {

MatteImageOptions options_for(std::string method) {
  return {.how = std::move(method),
          .picture = matting::photograph(matting::Scene{}),
          .trimap = {},
          .scribbled = {}};
}

double error(const Result<Image>& matte) {
  EXPECT_THAT(matte, IsOk());
  return matte ? matte_mad(*matte, to_image(matting::truth(matting::Scene{}))) : 1;
}

TEST(MatteImage, KeysClothWithoutBeingToldAnything) {
  EXPECT_LT(error(matte_image(options_for("chroma"))), 0.01);
  EXPECT_LE(error(matte_image(options_for("auto"))), 0.01);
}

TEST(MatteImage, FollowsScribblesAndATrimap) {
  MatteImageOptions options = options_for("closed-form");
  options.scribbled = options.picture;
  for (int x = 60; x < 100; ++x)
    for (int c = 0; c < 3; ++c)
      options.scribbled.at(x, 60)[c] = 255, options.scribbled.at(x, 5)[c] = 0,
                              options.scribbled.at(x, 115)[c] = 0;
  EXPECT_LT(error(matte_image(options)), 0.05);
  options = options_for("auto");
  options.trimap = Image(160, 120, 1, 128);
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 160; ++x) {
      const double d = std::hypot(x - 80.0, y - 60.0);
      if (d < 24 || d > 38) *options.trimap.at(x, y) = d < 24 ? 255 : 0;
    }
  EXPECT_LT(error(matte_image(options)), 0.01);
}

TEST(MatteImage, ChoosesSpectralComponentsByClicksScribblesOrItsOwnGuess) {
  const matting::DiscPicture disc = matting::disc_picture(120, 90);
  MatteImageOptions options{.how = "spectral", .picture = disc.rgb, .trimap = {}, .scribbled = {}};
  const auto off = [&] {
    const Result<Image> matte = matte_image(options);
    EXPECT_THAT(matte, IsOk());
    return matte ? matte_mad(*matte, disc.alpha) : 1;
  };
  EXPECT_LT(off(), 0.05) << "its own guess";
  options.clicks = {{MatteLabel::Foreground, 2, {{54, 45}}}};
  EXPECT_LT(off(), 0.05);
  const Image by_click = *matte_image(options);
  options.how = "auto";
  EXPECT_THAT(matte_image(options), IsOkAnd(by_click)) << "clicks alone";
  options.how = "spectral";
  options.clicks = {{MatteLabel::Background, 2, {{5, 5}}}};
  EXPECT_THAT(matte_image(options), FailsWith(ErrorCode::InvalidArgument, "only background"));
  options.clicks.clear();
  options.scribbled = options.picture;
  for (int x = 45; x < 62; ++x)
    for (int c = 0; c < 3; ++c) options.scribbled.at(x, 45)[c] = 255, options.scribbled.at(x, 4)[c] = 0;
  EXPECT_LT(off(), 0.05);
  options.picture = Image(120, 90, 3, 80);
  options.scribbled = {};
  EXPECT_THAT(matte_image(options), FailsWith(ErrorCode::BadData, ""));
}

TEST(MatteImage, SaysWhatItNeeds) {
  EXPECT_THAT(matte_image(options_for("closed-form")), FailsWith(ErrorCode::InvalidArgument, "--trimap"));
  EXPECT_THAT(matte_image(options_for("magic")), FailsWith(ErrorCode::InvalidArgument, "closed-form"));
  MatteImageOptions options = options_for("auto");
  options.trimap = Image(10, 10, 1);
  EXPECT_THAT(matte_image(options), FailsWith(ErrorCode::InvalidArgument, "10x10"));
  options = options_for("auto");
  options.picture = Image(40, 30, 3, 77);
  EXPECT_THAT(matte_image(options), FailsWith(ErrorCode::NotFound, "--scribbles"));
}

// A disc in the middle is known, and the corners.
Image wide_trimap() {
  Image trimap(160, 120, 1, 128);
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 160; ++x) {
      const double d = std::hypot(x - 80.0, y - 60.0);
      if (d < 20 || d > 60) *trimap.at(x, y) = d < 20 ? 255 : 0;
    }
  return trimap;
}

TEST(MatteImage, SolvesATrimapFromCoarseToFineUnlessAskedForThePublishedMethod) {
  MatteImageOptions options = options_for("auto");
  options.trimap = wide_trimap();
  const Result<Image> held = matting::pyramid_matte(options.picture, options.trimap),
                      alone = matting::closed_form_matte(options.picture, options.trimap);
  ASSERT_THAT(held, IsOk());
  ASSERT_THAT(alone, IsOk());
  EXPECT_NE(held->pixels, alone->pixels);
  EXPECT_THAT(matte_image(options), IsOkAnd(*held));
  options.how = "pyramid";
  EXPECT_THAT(matte_image(options), IsOkAnd(*held));
  options.how = "closed-form";
  EXPECT_THAT(matte_image(options), IsOkAnd(*alone));
}

TEST(MatteImage, RefusesATrimapThatMarksOneSideOnly) {
  for (const std::string how : {"auto", "pyramid", "closed-form"}) {
    MatteImageOptions options = options_for(how);
    options.trimap = wide_trimap();
    for (std::uint8_t& v : options.trimap.pixels) v = v == 255 ? 128 : v;
    EXPECT_THAT(matte_image(options), FailsWith(ErrorCode::InvalidArgument, "mark some of the subject"));
    options.trimap = wide_trimap();
    for (std::uint8_t& v : options.trimap.pixels) v = v == 0 ? 128 : v;
    EXPECT_THAT(matte_image(options), FailsWith(ErrorCode::InvalidArgument, "mark some of the background"));
  }
}

TEST(MatteImage, LeavesATrimapThatIsAllSubjectOrAllBackgroundAlone) {
  for (const std::uint8_t value : {0, 255}) {
    MatteImageOptions options = options_for("auto");
    options.trimap = Image(160, 120, 1, value);
    EXPECT_THAT(matte_image(options), IsOkAnd(options.trimap));
  }
}

}  // namespace
}  // namespace floatstage::pipeline
