#include "matting/closed_form.h"

#include <algorithm>
#include <cmath>

#include "core/random.h"
#include "tests/matting/pictures.h"
#include "tests/support/matchers.h"

namespace floatstage::matting {
namespace {

// The truth's trimap: unknown within about `margin` px of where it is neither 0 nor 255.
Image trimap_of(const Image& alpha, int margin) {
  return trimap_around(alpha, {.margin = margin, .soft_from = 1, .soft_to = 254});
}

double worst_difference(const Image& a, const Image& b) {
  double worst = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i)
    worst = std::max(worst, std::abs(a.pixels[i] - b.pixels[i]) / 255.0);
  return worst;
}

Scene two_colours() {
  Scene scene;
  scene.vignette = 0;
  return scene;
}

TEST(ClosedForm, IsExactWhereBothSidesHaveOneColour) {
  const Scene scene = two_colours();
  const Image alpha = to_image(truth(scene));
  const Result<Image> solved = closed_form_matte(photograph(scene), trimap_of(alpha, 6));
  ASSERT_THAT(solved, IsOk());
  EXPECT_LE(worst_difference(*solved, alpha), 2.5 / 255) << "8-bit colours tell opacity to a step or two";
}

TEST(ClosedForm, FollowsUnevenLight) {
  const Image alpha = to_image(truth(Scene{}));
  const Result<Image> solved = closed_form_matte(photograph(Scene{}), trimap_of(alpha, 6));
  ASSERT_THAT(solved, IsOk());
  EXPECT_LE(worst_difference(*solved, alpha), 0.05);
}

TEST(ClosedForm, SpreadsTwoClicksOverBothSides) {
  const Scene scene = two_colours();
  Image trimap(scene.width, scene.height, 1, 128);
  *trimap.at(80, 60) = 255;
  *trimap.at(5, 5) = 0;
  const Result<Image> solved = closed_form_matte(photograph(scene), trimap);
  ASSERT_THAT(solved, IsOk());
  EXPECT_LE(worst_difference(*solved, to_image(truth(scene))), 0.03);
}

TEST(ClosedForm, LeavesATrimapWithoutUnknownPixelsAlone) {
  for (const std::uint8_t value : {0, 255}) {
    const Image trimap(160, 120, 1, value);
    EXPECT_THAT(closed_form_matte(photograph(Scene{}), trimap), IsOkAnd(trimap));
  }
}

TEST(ClosedForm, AnswersAPictureOfOneColourSmoothly) {
  Image trimap(40, 30, 1, 128);
  for (int y = 0; y < 30; ++y) *trimap.at(0, y) = 0, *trimap.at(39, y) = 255;
  const Result<Image> solved = closed_form_matte(Image(40, 30, 3, 90), trimap);
  ASSERT_THAT(solved, IsOk());
  for (int x = 1; x < 39; ++x) EXPECT_GE(*solved->at(x, 15) + 2, *solved->at(x - 1, 15)) << x;
  EXPECT_LT(*solved->at(5, 15), 80);
  EXPECT_GT(*solved->at(35, 15), 175);
}

TEST(ClosedForm, TakesAPriorWhereNothingIsKnown) {
  const Scene scene = two_colours();
  Image prior = to_image(truth(scene));
  for (std::uint8_t& p : prior.pixels) p = p >= 128 ? 200 : 40;  // a faint opinion, wrong at the edge
  ClosedFormOptions options;
  options.prior = 1e-3;
  const Result<Image> solved = closed_form_matte(photograph(scene), Image(160, 120, 1, 128), options, prior);
  ASSERT_THAT(solved, IsOk());
  EXPECT_NEAR(*solved->at(80, 60), 200, 3);
  EXPECT_NEAR(*solved->at(5, 5), 40, 3);
}

TEST(ClosedForm, SolvesAPictureThatIsTooLargeCoarseToFine) {
  Scene scene = two_colours();
  scene.width = 320, scene.height = 240, scene.radius = 70;
  const Image alpha = to_image(truth(scene)), trimap = trimap_of(alpha, 20);
  ClosedFormOptions options;
  options.most_unknown = 6000;
  const Result<Image> coarse = closed_form_matte(photograph(scene), trimap, options),
                      whole = closed_form_matte(photograph(scene), trimap);
  ASSERT_THAT(coarse, IsOk());
  ASSERT_THAT(whole, IsOk());
  EXPECT_LE(worst_difference(*coarse, *whole), 0.06);
  options.most_unknown = 1000;
  scene.noise = 4;  // so that a soft matte leaves a band that is too large once more
  EXPECT_THAT(closed_form_matte(photograph(scene), Image(trimap), options), IsOk());
}

TEST(ClosedForm, GivesTheSameBytesAgain) {
  Scene scene;
  scene.noise = 3;
  const Image picture = photograph(scene), trimap = trimap_of(to_image(truth(scene)), 8);
  EXPECT_EQ(*closed_form_matte(picture, trimap), *closed_form_matte(picture, trimap));
}

TEST(ClosedForm, RefusesWhatDoesNotFit) {
  const Image picture = photograph(Scene{});
  EXPECT_THAT(closed_form_matte(picture, Image(80, 60, 1, 128)),
              FailsWith(ErrorCode::InvalidArgument, "80x60"));
  EXPECT_THAT(closed_form_matte(picture, Image(160, 120, 1, 128)),
              FailsWith(ErrorCode::InvalidArgument, "nothing in the trimap is known"));
  EXPECT_THAT(closed_form_matte(Image(2, 2, 3), Image(2, 2, 1)),
              FailsWith(ErrorCode::InvalidArgument, "2x2"));
  ClosedFormOptions options;
  options.constraint = 0;
  EXPECT_THAT(closed_form_matte(picture, Image(160, 120, 1, 0), options),
              FailsWith(ErrorCode::InvalidArgument, "constraint"));
}

TEST(TrimapAround, MarksSoftPixelsAndHardEdgesWithAMargin) {
  Image hard(40, 30, 1);
  for (int y = 0; y < 30; ++y)
    for (int x = 20; x < 40; ++x) *hard.at(x, y) = 255;
  const Image trimap = trimap_around(hard, {.margin = 3});
  EXPECT_EQ(*trimap.at(15, 15), 0);
  EXPECT_EQ(*trimap.at(16, 15), 128);
  EXPECT_EQ(*trimap.at(23, 15), 128);
  EXPECT_EQ(*trimap.at(24, 15), 255);
  Image soft(40, 30, 1);
  *soft.at(10, 10) = 60;
  const Image around = trimap_around(soft, {.margin = 0});
  EXPECT_EQ(std::count(around.pixels.begin(), around.pixels.end(), 128), 1);
}

TEST(TrimapFromScribbles, KnowsWhatWasPainted) {
  const Image picture = photograph(Scene{});
  Image scribbled = picture;
  for (int c = 0; c < 3; ++c) scribbled.at(4, 5)[c] = 255, scribbled.at(6, 7)[c] = 0;
  const Result<Image> trimap = trimap_from_scribbles(picture, scribbled);
  ASSERT_THAT(trimap, IsOk());
  EXPECT_EQ(*trimap->at(4, 5), 255);
  EXPECT_EQ(*trimap->at(6, 7), 0);
  EXPECT_EQ(std::count(trimap->pixels.begin(), trimap->pixels.end(), 128), 160 * 120 - 2);
  EXPECT_THAT(trimap_from_scribbles(picture, Image(160, 120, 1)),
              FailsWith(ErrorCode::InvalidArgument, "channels"));
}

TEST(RefineMatte, BringsASmallMatteToTheLargePicturesEdges) {
  Scene large = two_colours();
  large.width = 640, large.height = 480, large.radius = 120;
  Scene small = two_colours();
  small.radius = 30;
  const Result<Image> refined = refine_matte(photograph(large), to_image(truth(small)));
  ASSERT_THAT(refined, IsOk());
  EXPECT_LE(worst_difference(*refined, to_image(truth(large))), 0.05);
}

TEST(RefineMatte, CorrectsARoughEdge) {
  const Scene scene = two_colours();
  Scene larger = scene;
  larger.radius += 2;
  const Result<Image> refined = refine_matte(photograph(scene), to_image(truth(larger)), [] {
    RefineOptions options;
    options.band.margin = 5;
    return options;
  }());
  ASSERT_THAT(refined, IsOk());
  EXPECT_LE(worst_difference(*refined, to_image(truth(scene))), 0.05);
}

TEST(RefineMatte, KeepsWhatAPersonSaid) {
  const Scene scene = two_colours();
  Image keep(scene.width, scene.height, 1, 128);
  *keep.at(80, 60) = 0;
  const Result<Image> refined = refine_matte(photograph(scene), to_image(truth(scene)), {}, keep);
  ASSERT_THAT(refined, IsOk());
  EXPECT_EQ(*refined->at(80, 60), 0);
}

TEST(RefineMatte, LeavesAnEmptyAndAFullMatteAlone) {
  for (const std::uint8_t value : {0, 255})
    EXPECT_THAT(refine_matte(photograph(Scene{}), Image(160, 120, 1, value)),
                IsOkAnd(Image(160, 120, 1, value)));
}

TEST(RefineMatte, RefusesAnotherShape) {
  EXPECT_THAT(refine_matte(photograph(Scene{}), Image(40, 60, 1)),
              FailsWith(ErrorCode::InvalidArgument, "shape"));
}

// A JPEG's own pixels are not those of the PNG that somebody painted on: all of it would count as strokes.
TEST(ClosedForm, TellsScribblesFromAPictureThatWasCodedAnew) {
  const Image picture = photograph(Scene{});
  Image scribbled = picture;
  for (int x = 60; x < 100; ++x) std::fill_n(scribbled.at(x, 60), 3, 255);
  EXPECT_THAT(trimap_from_scribbles(picture, scribbled), IsOk());
  for (std::uint8_t& v : scribbled.pixels) v = static_cast<std::uint8_t>(std::clamp(v + 1, 6, 249));
  EXPECT_THAT(trimap_from_scribbles(picture, scribbled),
              FailsWith(ErrorCode::InvalidArgument, "without loss"));
}

}  // namespace
}  // namespace floatstage::matting
