#include "render/zipmap/gl_zipmap.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/gl_context.h"
#include "tests/render/zipmap/pictures.h"
#include "tests/support/matchers.h"

namespace floatstage::render {
namespace {

using namespace test;
using Eigen::Matrix3d;
using Wrap = Zipmap::Wrap;

class GlZipmaps : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    Result<std::unique_ptr<GlContext>> made = GlContext::headless();
    ASSERT_THAT(made, IsOk());
    context_ = std::move(*made);
  }
  static void TearDownTestSuite() { context_.reset(); }

  static std::unique_ptr<GlZipmap> drawn_by_gl(Zipmap zipmap, const GlZipmapOptions& options = {}) {
    Result<std::unique_ptr<GlZipmap>> made =
        GlZipmap::make(std::make_shared<const Zipmap>(std::move(zipmap)), options);
    EXPECT_THAT(made, IsOk());
    return made ? std::move(*made) : nullptr;
  }
  // Mean difference of the two pictures, steps of 255.
  static double difference(GlZipmap& gl, const ZipmapView& view) {
    EXPECT_THAT(gl.draw(view), IsOk());
    return mean_difference(gl.read(),
                           gl.zipmap().draw(view.uv_from_pixel, view.width, view.height, view.wrap));
  }

  static std::unique_ptr<GlContext> context_;
};
std::unique_ptr<GlContext> GlZipmaps::context_;

TEST_F(GlZipmaps, AreTheReferenceWithManyPatchesAtEveryDistanceAndWrap) {
  Matrix3d oblique = window(-0.4, -0.2, 1.6, 90);
  oblique(2, 0) = 0.004;
  oblique(2, 1) = -0.002;
  for (const int count : {0, 1, 16, 40, 255}) {
    const std::unique_ptr<GlZipmap> gl = drawn_by_gl(scattered(count));
    for (const Wrap wrap : {Wrap::Repeat, Wrap::Clamp, Wrap::Mirror})
      for (const Matrix3d& from : {window(0, 0, 1, 90), window(-0.7, -0.3, 2.5, 90),
                                   window(0.3, 0.3, 0.2, 90), window(0.41, 0.37, 0.01, 90), oblique})
        EXPECT_LE(difference(*gl, {from, 90, 71, wrap}), 1) << count << " patches, wrap " << int(wrap);
  }
}

// What a driver mixes of texels of 8 bits may be rounded to these: half a step.
TEST_F(GlZipmaps, OfAPhotographsSizeAreTheReferenceToAFractionOfAStep) {
  const std::unique_ptr<GlZipmap> gl = drawn_by_gl(ever_closer());
  for (const double size : {1.0, 0.31, 0.07, 0.004})
    EXPECT_LE(difference(*gl, {window(0.5 - size / 2, 0.5 - size / 2, size, 160), 160, 120}), 0.5) << size;
}

// Drivers may choose the level of four pixels at once: beside a line on which it changes some are then of
// another level than they asked for.
TEST_F(GlZipmaps, SeenAtAnAngleAreTheReferenceInEveryPixel) {
  const std::unique_ptr<GlZipmap> gl = drawn_by_gl(ever_closer());
  Matrix3d oblique = window(0.3, 0.3, 0.9, 160);
  oblique(2, 0) = 0.003, oblique(2, 1) = 0.002;
  ASSERT_THAT(gl->draw({oblique, 160, 120}), IsOk());
  const Image picture = gl->read(), truth = gl->zipmap().draw(oblique, 160, 120);
  int most = 0;
  for (std::size_t i = 0; i < truth.pixels.size(); ++i)
    most = std::max(most, std::abs(picture.pixels[i] - truth.pixels[i]));
  EXPECT_LE(most, 2);
}

TEST_F(GlZipmaps, WithMorePatchesThanLayersAreDrawnInSeveralPassesToTheSamePicture) {
  const ZipmapView view{window(0, 0, 1, 120), 120, 90};
  const std::unique_ptr<GlZipmap> all = drawn_by_gl(scattered(40));
  const std::unique_ptr<GlZipmap> few = drawn_by_gl(scattered(40), {.most_layers = 1});
  EXPECT_EQ(all->layers(), 3) << "patches of one picture share its layer";
  EXPECT_EQ(few->layers(), 1);
  const Result<DrawnZipmap> once = all->draw(view), often = few->draw(view);
  ASSERT_THAT(once, IsOk());
  ASSERT_THAT(often, IsOk());
  EXPECT_EQ(once->passes, 1);
  EXPECT_EQ(often->passes, 40);
  EXPECT_EQ(often->patches, 40);
  EXPECT_LE(mean_difference(all->read(), few->read()), 0.2);
  EXPECT_LE(difference(*few, view), 1);
}

TEST_F(GlZipmaps, HaveNoSeamsWherePatchesShowTheRootsColours) {
  std::vector<Zipmap::Patch> patches;
  for (int i = 0; i < 9; ++i) patches.push_back(patch(0, 0.1 + 0.05 * i, 0.13 + 0.031 * i, 0.3));
  const std::unique_ptr<GlZipmap> gl =
      drawn_by_gl(*Zipmap::make(Image(64, 64, 3, 123), {Image(100, 77, 3, 123)}, patches));
  for (const double size : {2.0, 1.0, 0.4, 0.05}) {
    ASSERT_THAT(gl->draw({window(0.2, 0.2, size, 97), 97, 80}), IsOk());
    EXPECT_THAT(gl->read().pixels, testing::Each(123)) << size;
  }
}

TEST_F(GlZipmaps, DoNotPopWhileOneZoomsIn) {
  const std::unique_ptr<GlZipmap> gl = drawn_by_gl(ever_closer());
  double size = 1, most = 0;
  Image before;
  for (int step = 0; step < 350; ++step, size *= 0.99) {
    ASSERT_THAT(gl->draw({window(0.5 - size / 2, 0.5 - size * 3 / 8, size, 160), 160, 120}), IsOk());
    Image now = gl->read();
    if (step > 0) most = std::max(most, mean_difference(before, now));
    before = std::move(now);
  }
  EXPECT_LE(most, 2) << "steps of 255 from one per cent to the next";
}

TEST_F(GlZipmaps, KeepWithinTheirBudgetAndDrawAllOfItNevertheless) {
  // Twelve pictures of 64x64 px: 21,844 bytes with their levels each; root 4,095.
  std::vector<Image> pictures;
  std::vector<Zipmap::Patch> patches;
  for (std::size_t i = 0; i < 12; ++i) {
    pictures.push_back(noise(64, 64, 4, i));
    patches.push_back(patch(i, 0.07 * static_cast<double>(i), 0.3, 0.2));
  }
  const Zipmap zipmap = *Zipmap::make(noise(32, 32, 3, 99), pictures, patches);
  const std::unique_ptr<GlZipmap> gl = drawn_by_gl(zipmap, {.budget = 4'095 + 4 * 21'844 + 100});
  EXPECT_EQ(gl->layers(), 4);
  EXPECT_EQ(gl->allocated(), 4'095u + 4 * 21'844u);
  EXPECT_LE(difference(*gl, {window(0, 0, 1, 90), 90, 90}), 1);
  // Close by, four layers are enough, and what is there stays.
  const ZipmapView close{window(0.05, 0.3, 0.1, 90), 90, 90};
  EXPECT_LE(difference(*gl, close), 1);
  const Result<DrawnZipmap> again = gl->draw(close);
  EXPECT_EQ(again->passes, 1);
  EXPECT_EQ(again->loaded, 0u);
  EXPECT_THAT(GlZipmap::make(std::make_shared<const Zipmap>(zipmap), {.budget = 20'000}),
              FailsWith(ErrorCode::InvalidArgument, "video memory"));
}

TEST_F(GlZipmaps, LoadWhatTheViewNeedsAndNoMore) {
  const std::unique_ptr<GlZipmap> gl = drawn_by_gl(ever_closer());
  // From afar the three photographs are a few pixels wide.
  const Result<DrawnZipmap> far = gl->draw({window(-1, -1, 3, 64), 64, 64});
  ASSERT_THAT(far, IsOk());
  EXPECT_LT(far->loaded, 3 * 4 * 16 * 16u) << "their coarse levels only";
  EXPECT_EQ(far->waiting, 0u);
  // A little at a time: the picture gets nearer to what it is to be with each.
  const ZipmapView close{window(0.42, 0.42, 0.16, 160), 160, 160};
  const Image whole = gl->zipmap().draw(close.uv_from_pixel, 160, 160);
  std::size_t waiting = 1;
  double last = 255;
  for (int turn = 0; turn < 30 && waiting > 0; ++turn) {
    const Result<DrawnZipmap> drawn = gl->draw(close, {.most_loaded = 40'000});
    ASSERT_THAT(drawn, IsOk());
    waiting = drawn->waiting;
    const double now = mean_difference(gl->read(), whole);
    EXPECT_LE(now, last + 0.3);
    last = now;
  }
  EXPECT_EQ(waiting, 0u);
  EXPECT_LE(last, 0.3);
}

TEST_F(GlZipmaps, ShowTheirRootAloneAndWhereItsPatchesAre) {
  const std::unique_ptr<GlZipmap> gl =
      drawn_by_gl(*Zipmap::make(Image(32, 32, 3, 60), {Image(64, 64, 3, 200)}, {patch(0, 0.25, 0.25, 0.5)}));
  const ZipmapView view{window(0, 0, 1, 40), 40, 40};
  ASSERT_THAT(gl->draw(view, {.plain_from = 0}), IsOk());
  EXPECT_THAT(gl->read().pixels, testing::Each(60));
  ZipmapDrawing tinted;
  tinted.tints = {1, {0, 0, 1}, {0, 1, 0}, {{1, 0, 0}}};
  tinted.plain_from = 25;
  ASSERT_THAT(gl->draw(view, tinted), IsOk());
  const Image picture = gl->read();
  EXPECT_THAT(std::vector<int>(picture.at(2, 2), picture.at(2, 2) + 3), testing::ElementsAre(0, 0, 255));
  EXPECT_THAT(std::vector<int>(picture.at(20, 20), picture.at(20, 20) + 3), testing::ElementsAre(255, 0, 0));
  EXPECT_EQ(picture.at(24, 20)[0], 255);
  EXPECT_EQ(picture.at(25, 20)[0], 60) << "plain";
}

TEST_F(GlZipmaps, TakeAHundredMegabytesWhereAFlatTextureTakesSeventeenThousand) {
  const std::unique_ptr<GlZipmap> gl = drawn_by_gl(thirty_two_times());
  EXPECT_NEAR(gl->zipmap().finest(), 32, 1e-9);
  EXPECT_LE(static_cast<double>(gl->allocated()), 110e6);
  EXPECT_EQ(gl->allocated(), gl->zipmap().bytes());
  EXPECT_GT(gl->zipmap().bytes_when_flat(), 17e9);
}

}  // namespace
}  // namespace floatstage::render
