#include "matting/keyers/plate.h"

#include <algorithm>
#include <cmath>

#include "core/random.h"
#include "matting/keyers/plate_kernels.h"
#include "tests/matting/pictures.h"
#include "tests/support/matchers.h"

namespace floatstage::matting {
namespace {

Scene noisy() {
  Scene scene;
  scene.noise = 2;
  return scene;
}

std::vector<Image> empty_stages(int count) {
  std::vector<Image> all;
  for (int i = 0; i < count; ++i) all.push_back(empty_stage(noisy(), 100 + static_cast<std::uint64_t>(i)));
  return all;
}

// A square of another colour that stays at (x, 50) … (x + 30, 80).
Image with_square(Image picture, int x) {
  for (int v = 50; v < 80; ++v)
    for (int u = x; u < x + 30; ++u) std::fill_n(picture.at(u, v), 3, std::uint8_t{200});
  return picture;
}

TEST(Plate, IsCleanerThanAnyOfItsPhotographsAndKnowsTheirNoise) {
  Scene still = noisy();
  still.noise = 0;
  const Image truth = empty_stage(still);
  const Result<Plate> plate = learn_plate(empty_stages(25));
  ASSERT_THAT(plate, IsOk());
  EXPECT_GT(psnr(plate->color, truth), psnr(empty_stages(1)[0], truth) + 8);
  double sum = 0;
  for (const std::uint8_t n : plate->noise.pixels) sum += n / 16.0;
  EXPECT_NEAR(sum / static_cast<double>(plate->noise.pixels.size()), 2.0, 0.3);
  EXPECT_GT(*std::min_element(plate->confidence.pixels.begin(), plate->confidence.pixels.end()), 240);
}

TEST(Plate, IsFoundBehindSomebodyWhoLeavesEachPlaceSoonerOrLater) {
  std::vector<Image> take = empty_stages(12);
  for (int i = 0; i < 12; ++i) take[i] = with_square(take[i], 10 + 9 * i);
  const Result<Plate> plate = learn_plate(take);
  ASSERT_THAT(plate, IsOk());
  EXPECT_GT(psnr(plate->color, empty_stage(noisy())), 38);
}

TEST(Plate, IsUnknownWhereFewerPicturesThanAskedForShowTheSame) {
  std::vector<Image> take = empty_stages(8);
  for (int i = 0; i < 8; ++i)  // each picture another brightness: nothing was ever seen behind
    for (int v = 50; v < 80; ++v)
      for (int u = 60; u < 90; ++u) std::fill_n(take[i].at(u, v), 3, static_cast<std::uint8_t>(30 * i + 20));
  const Result<Plate> plate = learn_plate(take, {.fewest = 3});
  ASSERT_THAT(plate, IsOk());
  EXPECT_EQ(*plate->confidence.at(75, 65), 0);
  EXPECT_GT(*plate->confidence.at(20, 20), 240);
  const Image classes = classify(*plate, plate->color);
  EXPECT_EQ(*classes.at(75, 65), static_cast<int>(PlateClass::Subject)) << "even what looks like it";
  EXPECT_EQ(*classes.at(20, 20), static_cast<int>(PlateClass::Plate));
  const Matte matte = *(*make_plate_keyer(*plate))->key(make_frame({}, take[5]));
  EXPECT_EQ(matte.row(65)[75], 255);
  EXPECT_EQ(matte.row(20)[20], 0);
  EXPECT_THAT(learn_plate(take, {.fewest = 0}), FailsWith(ErrorCode::InvalidArgument, "fewest"));
}

TEST(Plate, OfSomebodyWhoStaysIsLearntAgainFromMattes) {
  std::vector<Image> take = empty_stages(12), mattes(12, Image(160, 120, 1));
  for (int i = 0; i < 9; ++i) {  // three quarters of the time in one place
    take[i] = with_square(take[i], 60);
    for (int y = 50; y < 80; ++y) std::fill_n(mattes[i].at(60, y), 30, std::uint8_t{255});
  }
  const Result<Plate> first = learn_plate(take), again = learn_plate(take, {}, mattes);
  ASSERT_THAT(again, IsOk());
  EXPECT_EQ(first->color.at(75, 65)[0], 200) << "nobody can know";
  EXPECT_LT(again->color.at(75, 65)[0], 60);
}

TEST(Plate, RefusesWhatIsNoSet) {
  EXPECT_THAT(learn_plate({}), FailsWith(ErrorCode::InvalidArgument, "at least one"));
  EXPECT_THAT(learn_plate({Image(4, 4, 3), Image(5, 4, 3)}), FailsWith(ErrorCode::InvalidArgument, "5x4"));
  EXPECT_THAT(learn_plate({Image(4, 4, 3)}, {}, {Image(3, 3, 1)}),
              FailsWith(ErrorCode::InvalidArgument, "3x3"));
  EXPECT_THAT(learn_plate({Image(4, 4, 3)}, {}, {Image(4, 4, 1), Image(4, 4, 1)}),
              FailsWith(ErrorCode::InvalidArgument, "2 mattes"));
}

TEST(PlateKey, TellsShadowReflexAndSubjectApart) {
  const Plate plate = *learn_plate(empty_stages(9));
  Image picture = plate.color;
  const auto paint = [&](int x, double light) {
    for (int y = 40; y < 60; ++y)
      for (int u = x; u < x + 10; ++u)
        for (int c = 0; c < 3; ++c)
          picture.at(u, y)[c] = static_cast<std::uint8_t>(std::min(255.0, light * plate.color.at(u, y)[c]));
  };
  paint(20, 0.65);
  paint(40, 1.14);
  paint(60, 0.2);
  for (int y = 40; y < 60; ++y) std::fill_n(picture.at(80, y), 30, std::uint8_t{180});
  const Image classes = classify(plate, picture);
  const auto at = [&](int x) { return static_cast<PlateClass>(*classes.at(x, 50)); };
  EXPECT_EQ(at(5), PlateClass::Plate);
  EXPECT_EQ(at(25), PlateClass::Shadow);
  EXPECT_EQ(at(45), PlateClass::Reflex);
  EXPECT_EQ(at(65), PlateClass::Subject) << "black trousers are no shadow";
  EXPECT_EQ(at(85), PlateClass::Subject);
}

TEST(PlateKey, IsFrozenAnActorWhoStandsStillDoesNotMeltAway) {
  const auto keyer = make_plate_keyer(*learn_plate(empty_stages(9)));
  ASSERT_THAT(keyer, IsOk());
  const Frame frame = make_frame({}, photograph(noisy()));
  const Image first = to_image(*(*keyer)->key(frame));
  for (int i = 0; i < 50; ++i) ASSERT_THAT((*keyer)->key(frame), IsOk());
  EXPECT_EQ(to_image(*(*keyer)->key(frame)), first);
  EXPECT_GE(iou(*(*keyer)->key(frame), truth(noisy())), 0.97);
}

TEST(PlateKey, IsAsTolerantAsAPixelIsNoisy) {
  // A lamp flickers in one corner of every photograph of the empty stage; a key of one threshold sees it.
  std::vector<Image> stages = empty_stages(16);
  Random random(5);
  const auto flicker = [&](Image& image) {
    for (int y = 0; y < 30; ++y)
      for (int x = 0; x < 30; ++x)
        for (int c = 0; c < 3; ++c)
          image.at(x, y)[c] =
              static_cast<std::uint8_t>(std::clamp(image.at(x, y)[c] + 5 * random.normal(), 0.0, 255.0));
  };
  for (Image& s : stages) flicker(s);
  Image now = empty_stage(noisy(), 999);
  flicker(now);
  const Image classes = classify(*learn_plate(stages), now);
  EXPECT_LT(std::count(classes.pixels.begin(), classes.pixels.end(), 3), 10);
  Plate quiet = *learn_plate(stages);
  std::fill(quiet.noise.pixels.begin(), quiet.noise.pixels.end(), std::uint8_t{16});
  const Image seen = classify(quiet, now, {.sigmas = 6, .least = 6});
  EXPECT_GT(std::count(seen.pixels.begin(), seen.pixels.end(), 3), 100);
}

TEST(PlateKey, SaysWhichThresholdIsWrong) {
  const Plate plate = *learn_plate(empty_stages(2));
  EXPECT_THAT(make_plate_keyer(plate, {.sigmas = 0}), FailsWith(ErrorCode::InvalidArgument, "plate:0"));
  EXPECT_THAT(make_plate_keyer(plate, {.least = 50, .most = 20}),
              FailsWith(ErrorCode::InvalidArgument, "50"));
  EXPECT_THAT(make_plate_keyer(plate, {.darkest_shadow = 1.5}),
              FailsWith(ErrorCode::InvalidArgument, "shadow"));
}

// The arithmetic of difference() in plate_keyer.cpp, whatever the processor.
TEST(PlateKernels, GiveTheSameBitsOnAllInstructionSets) {
  constexpr std::size_t kCount = 16 * 31 + 7;
  constexpr float kDarkest = 0.72F, kBrightest = 1.12F;
  Random random(7);
  std::vector<std::uint8_t> rgb(3 * kCount), plate(3 * kCount);
  for (std::uint8_t& v : rgb) v = static_cast<std::uint8_t>(random.next() & 255);
  for (std::uint8_t& v : plate) v = static_cast<std::uint8_t>(random.next() & 255);
  std::vector<float> thresholds(kCount, 14.0F);
  for (std::size_t i = 0; i < kCount; i += 5) thresholds[i] = 0;
  for (const PlateKernels& kernels : all_plate_kernels()) {
    std::vector<float> lengths(kCount);
    std::vector<std::uint8_t> alphas(kCount);
    kernels.lengths(rgb.data(), plate.data(), kCount, kDarkest, kBrightest, lengths.data());
    kernels.alphas(rgb.data(), plate.data(), thresholds.data(), kCount, kDarkest, kBrightest, alphas.data());
    for (std::size_t i = 0; i < kCount; ++i) {
      const std::uint8_t *p = rgb.data() + 3 * i, *b = plate.data() + 3 * i;
      const float pr = p[0], pg = p[1], pb = p[2], br = b[0], bg = b[1], bb = b[2];
      const float bright = std::clamp((pr * br + pg * bg + pb * bb) / (br * br + bg * bg + bb * bb + 1e-3F),
                                      kDarkest, kBrightest);
      const float dr = pr - bright * br, dg = pg - bright * bg, db = pb - bright * bb;
      const float length = std::sqrt(dr * dr + dg * dg + db * db);
      ASSERT_EQ(lengths[i], length) << kernels.name;
      const float ramp = std::clamp((length / 14 - 0.5F) * 255 + 0.5F, 0.0F, 255.0F);
      ASSERT_EQ(alphas[i], i % 5 == 0 ? 255 : static_cast<std::uint8_t>(ramp)) << kernels.name;
    }
  }
}

}  // namespace
}  // namespace floatstage::matting
