#include "matting/keyers/live_key.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/synthetic/synthetic_studio.h"
#include "matting/keyers/byte_closing.h"
#include "matting/keyers/cloth_kernels.h"
#include "matting/keyers/plate.h"
#include "matting/keyers/row_kernels.h"
#include "tests/matting/pictures.h"
#include "tests/support/matchers.h"

namespace floatstage::matting {
namespace {

struct Difference {
  long pixels = 0, steps_apart = 0;  // by more than two steps
  double share() const {
    return static_cast<double>(steps_apart) / static_cast<double>(std::max(pixels, 1L));
  }
};

Difference between(const Matte& a, const Matte& b) {
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  Difference all;
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x, ++all.pixels)
      all.steps_apart += std::abs(a.row(y)[x] - b.row(y)[x]) > 2;
  return all;
}

// Where a mean lies within rounding of the contrast that an edge is solved from, the pixel may keep its key
// in one of both: a ten-thousandth of the picture at most.
constexpr double kOnTheEdge = 1e-4;

void expect_same(const Keyer& keyer, const Frame& frame, const std::string& what, double most = 0) {
  LiveKey live(keyer);
  ASSERT_TRUE(live.fast()) << what;
  const Result<Matte> wanted = keyer.key(frame), made = live.key(frame);
  ASSERT_EQ(static_cast<bool>(wanted), static_cast<bool>(made)) << what;
  if (!wanted) {
    EXPECT_EQ(wanted.error().code, made.error().code) << what;
    EXPECT_EQ(wanted.error().message, made.error().message) << what;
    return;
  }
  EXPECT_LE(between(*wanted, *made).share(), most) << what;
}

TEST(LiveKey, IsTheKeyersMatteOfEveryCameraOfAStudio) {
  const Rig rig = synthetic_rig({.cameras = 4, .width = 512, .height = 384});
  const SyntheticStudio studio = std::move(*SyntheticStudio::create(rig, {.samples = 4}));
  for (int camera = 0; camera < 4; ++camera) {
    const auto keyer = std::move(*make_keyer("chroma", {studio.plate(camera)}));
    for (const int instant : {0, 9}) expect_same(*keyer, studio.shoot(camera, instant).frame, "a performer");
    expect_same(*keyer, make_frame({}, studio.plate(camera)), "an empty stage");
  }
}

TEST(LiveKey, IsTheKeyersMatteOfNoisyAndShadedPictures) {
  for (const double noise : {0.0, 2.0, 6.0, 15.0})
    for (const double vignette : {0.0, 0.5, 0.9})
      for (const int width : {64, 127, 160, 201}) {
        Scene scene;
        scene.noise = noise;
        scene.vignette = vignette;
        scene.width = width;
        const auto keyer = std::move(*make_keyer("chroma:#28783c", {}));
        expect_same(*keyer, make_frame({}, photograph(scene)),
                    "noise " + std::to_string(noise) + " vignette " + std::to_string(vignette));
      }
}

TEST(LiveKey, IsTheKeyersMatteWhateverTheCleanUp) {
  Scene scene;
  scene.noise = 12;
  const Frame frame = make_frame({}, photograph(scene));
  for (const CleanupOptions& cleanup :
       {CleanupOptions{.smallest_island = 0, .smallest_hole = 0}, CleanupOptions{.thin_radius = 1},
        CleanupOptions{.thin_radius = 5, .smallest_island = 0.001, .smallest_hole = 0.1},
        CleanupOptions{.thin_radius = 20, .largest_only = true}}) {
    const auto keyer = std::move(*make_keyer("chroma:#28783c", {}, cleanup));
    expect_same(*keyer, frame, "thin " + std::to_string(cleanup.thin_radius));
  }
}

TEST(LiveKey, IsTheKeyersAnswerToPicturesThatAreNoStage) {
  const auto keyer = std::move(*make_keyer("chroma:#28783c", {}));
  Random random(3);
  for (const auto& [width, height] :
       {std::pair(1, 1), std::pair(3, 70), std::pair(65, 40), std::pair(130, 90)}) {
    Image noise(width, height, 3);
    for (std::uint8_t& v : noise.pixels) v = static_cast<std::uint8_t>(random.uniform(0, 256));
    expect_same(*keyer, make_frame({}, noise), "noise");
    expect_same(*keyer, make_frame({}, Image(width, height, 3, 0)), "black");
    expect_same(*keyer, make_frame({}, Image(width, height, 3, 255)), "white");
    for (std::size_t i = 0; i < noise.pixels.size(); i += 3) {
      const bool cloth = random.uniform(0, 1) < 0.9;
      if (cloth) noise.pixels[i] = 40, noise.pixels[i + 1] = 120, noise.pixels[i + 2] = 60;
    }
    expect_same(*keyer, make_frame({}, noise), "specks");
  }
}

// Against a picture of the empty stage: whoever stands there is closed before he is cleaned.
TEST(LiveKey, IsTheMatteAgainstAPlateOfEveryCameraOfAStudio) {
  const Rig rig = synthetic_rig({.cameras = 4, .width = 512, .height = 384});
  const SyntheticStudio studio = std::move(*SyntheticStudio::create(rig, {.samples = 4}));
  for (const char* spec : {"plate", "difference", "plate:3", "difference:60"})
    for (int camera = 0; camera < 4; ++camera) {
      const auto keyer = std::move(*make_keyer(spec, {studio.plate(camera)}));
      for (const int instant : {0, 9})
        expect_same(*keyer, studio.shoot(camera, instant).frame, spec, kOnTheEdge);
      expect_same(*keyer, make_frame({}, studio.plate(camera)), "an empty stage");
    }
}

TEST(LiveKey, IsTheMatteAgainstAPlateOfNoisyPicturesWhateverTheCleanUp) {
  for (const double noise : {0.0, 2.0, 6.0, 15.0})
    for (const int width : {64, 127, 160, 201})
      for (const CleanupOptions& cleanup :
           {CleanupOptions{}, CleanupOptions{.close_radius = 1, .smallest_hole = 0.02},
            CleanupOptions{.close_radius = 3, .thin_radius = 2, .smallest_island = 0.02},
            CleanupOptions{.close_radius = 9, .largest_only = true}})
        for (const char* spec : {"plate", "difference", "chroma:#28783c"}) {
          Scene scene;
          scene.noise = noise;
          scene.width = width;
          const auto keyer =
              std::move(*make_keyer(spec, {empty_stage(scene), empty_stage(scene, 7)}, cleanup));
          expect_same(*keyer, make_frame({}, photograph(scene)),
                      spec + std::string(" noise ") + std::to_string(noise) + " width " +
                          std::to_string(width) + " close " + std::to_string(cleanup.close_radius),
                      kOnTheEdge);
        }
}

// A stripe beside the disc that a shadow darkens, and what others know of it at a fifth of the size.
TEST(LiveKey, TakesNoShadowOnTheFloorForTheSubjectAndForgetsItAfterwards) {
  Scene scene;
  scene.noise = 1;
  Image shadowed = photograph(scene);
  CastShade shade{.width = 32, .height = 24, .mask = {}, .left = {}};
  shade.mask.assign(32 * 24, 0);
  shade.left.assign(32 * 24, {0.5F, 0.6F, 0.7F});
  for (int y = 70; y < 110; ++y)
    for (int x = 20; x < 75; ++x) {
      if (disc_coverage(scene, x, y) > 0) continue;
      for (std::size_t c = 0; c < 3; ++c) {
        std::uint8_t& v = shadowed.at(x, y)[c];
        v = static_cast<std::uint8_t>(shade.left[0][c] * static_cast<float>(v));
      }
      shade.mask[static_cast<std::size_t>(y / 5 * 32 + x / 5)] = 255;
    }
  shade.shadows = static_cast<std::size_t>(std::count(shade.mask.begin(), shade.mask.end(), 255));
  const auto keyer = std::move(*make_keyer("plate", {empty_stage(scene), empty_stage(scene, 7)}));
  LiveKey live(*keyer);
  const Frame frame = make_frame({}, shadowed), plain = make_frame({}, photograph(scene));
  const Image before = to_image(*live.key(frame));
  EXPECT_LT(iou(*live.key(frame), truth(scene)), 0.9) << "else there is nothing to show";
  EXPECT_GT(iou(*live.key(frame, &shade), truth(scene)), iou(*live.key(plain), truth(scene)) - 0.01);
  EXPECT_GT(iou(*live.key(plain, &shade), truth(scene)), 0.97) << "he is no shadow, whoever says so";
  EXPECT_EQ(to_image(*live.key(frame)), before);
}

TEST(LiveKey, IsTheMatteAgainstAPlateThatIsUnknownInPlaces) {
  Scene scene;
  scene.noise = 3;
  Plate plate = std::move(*learn_plate({empty_stage(scene), empty_stage(scene, 7)}));
  for (int y = 20; y < 50; ++y) std::fill_n(plate.confidence.at(10, y), 60, std::uint8_t{0});
  const auto keyer = std::move(*make_plate_keyer(std::move(plate)));
  expect_same(*keyer, make_frame({}, photograph(scene)), "unknown beside the subject", kOnTheEdge);
  expect_same(*keyer, make_frame({}, empty_stage(scene, 9)), "unknown alone", kOnTheEdge);
}

TEST(LiveKey, IsTheKeyersAnswerToPicturesThatAreNotThePlates) {
  Random random(3);
  for (const auto& [width, height] :
       {std::pair(1, 1), std::pair(3, 70), std::pair(65, 40), std::pair(130, 90)}) {
    Image noise(width, height, 3);
    for (std::uint8_t& v : noise.pixels) v = static_cast<std::uint8_t>(random.uniform(0, 256));
    for (const char* spec : {"plate", "difference"}) {
      const auto keyer = std::move(*make_keyer(spec, {noise}));
      expect_same(*keyer, make_frame({}, noise), "itself");
      expect_same(*keyer, make_frame({}, Image(width, height, 3, 0)), "black", kOnTheEdge);
      expect_same(*keyer, make_frame({}, Image(width, height, 3, 255)), "white", kOnTheEdge);
      expect_same(*keyer, make_frame({}, Image(width, height + 1, 3)), "of another size");
    }
  }
}

TEST(LiveKey, IsTheKeyerItselfWhereNothingIsFaster) {
  const Scene scene{.backing = {3, 3, 3}};
  const auto keyer = std::move(*make_keyer("luminance", {empty_stage(scene)}));
  LiveKey live(*keyer);
  EXPECT_FALSE(live.fast());
  const Frame frame = make_frame({}, photograph(scene));
  EXPECT_EQ(to_image(*live.key(frame)), to_image(*keyer->key(frame)));
}

// The smallest, or the largest, value of a disc around every pixel.
Image around(const Image& in, int radius, bool largest) {
  Image out = in;
  for (int y = 0; y < in.height; ++y)
    for (int x = 0; x < in.width; ++x)
      for (int v = std::max(y - radius, 0); v <= std::min(y + radius, in.height - 1); ++v) {
        const double half = std::sqrt(radius * radius - (v - y) * (v - y));
        const int reach = static_cast<int>(std::lrint(half));
        for (int u = std::max(x - reach, 0); u <= std::min(x + reach, in.width - 1); ++u)
          *out.at(x, y) =
              largest ? std::max(*out.at(x, y), *in.at(u, v)) : std::min(*out.at(x, y), *in.at(u, v));
      }
  return out;
}

TEST(ByteClosing, IsTheSmallestOfTheLargestInDiscs) {
  Random random(11);
  for (const int radius : {0, 1, 2, 3, 5, 8})
    for (const auto& [width, height] :
         {std::pair(1, 1), std::pair(7, 3), std::pair(64, 20), std::pair(131, 60)}) {
      ByteClosing closing;
      closing.resize(width, height);
      Image picture(width, height, 1);
      for (std::uint8_t& v : picture.pixels)
        v = static_cast<std::uint8_t>(random.uniform(0, 1) < 0.9 ? 0 : random.uniform(0, 256));
      for (int y = 0; y < height; ++y) std::copy_n(picture.at(0, y), width, closing.row(y));
      closing.close(radius);
      const Image wanted = around(around(picture, radius, true), radius, false);
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
          ASSERT_EQ(closing.row(y)[x], *wanted.at(x, y)) << radius << ": " << x << ", " << y;
    }
}

TEST(RowKernels, GiveTheSameOnEveryInstructionSet) {
  Random random(5);
  const std::size_t count = 192;
  std::vector<std::uint8_t> a(count), b(count);
  std::vector<float> values(count);
  for (std::size_t x = 0; x < count; ++x) {
    a[x] = static_cast<std::uint8_t>(random.uniform(0, 256));
    b[x] = static_cast<std::uint8_t>(random.uniform(0, 256));
    values[x] = static_cast<float>(random.uniform(-500, 500));
  }
  for (const RowKernels& kernels : all_row_kernels()) {
    std::vector<std::int32_t> steps(count);
    std::vector<std::uint8_t> larger = a, smaller = a;
    kernels.quantize(values.data(), count, 64, steps.data());
    kernels.raise(b.data(), count - 5, larger.data());  // and what is left of a vector
    kernels.lower(b.data(), count - 5, smaller.data());
    for (std::size_t x = 0; x < count; ++x) {
      ASSERT_EQ(steps[x], std::lrint(64 * values[x])) << kernels.name;
      ASSERT_EQ(larger[x], x < count - 5 ? std::max(a[x], b[x]) : a[x]) << kernels.name;
      ASSERT_EQ(smaller[x], x < count - 5 ? std::min(a[x], b[x]) : a[x]) << kernels.name;
    }
  }
}

TEST(LiveKey, GivesTheSameWhateverItSawBeforeAndLeavesGivenMattesAlone) {
  const auto keyer = std::move(*make_keyer("chroma:#28783c", {}));
  Scene small, large;
  small.radius = 12;
  large.radius = 50;
  LiveKey live(*keyer), other(*keyer);
  const Image once = to_image(*other.key(make_frame({}, photograph(small))));
  const Matte held = *live.key(make_frame({}, photograph(large)));
  const Image before = to_image(held);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(to_image(*live.key(make_frame({}, photograph(small)))), once);
  EXPECT_EQ(to_image(held), before);
}

TEST(LiveKey, LeavesNothingOfPicturesOfAnotherSizeInAMatte) {
  Scene large, small;
  large.radius = 50;
  small.width = 127;
  const auto keyer = std::move(*make_keyer("chroma:#28783c", {}));
  LiveKey live(*keyer);
  const Image once = to_image(*LiveKey(*keyer).key(make_frame({}, photograph(small))));
  for (int i = 0; i < 2; ++i) {
    EXPECT_THAT(live.key(make_frame({}, photograph(large))), IsOk());
    EXPECT_EQ(to_image(*live.key(make_frame({}, photograph(small)))), once);
  }
}

TEST(LiveKey, RefusesWhatTheKeyerRefuses) {
  const auto keyer = std::move(*make_keyer("chroma:#28783c", {}));
  LiveKey live(*keyer);
  EXPECT_THAT(live.key(make_frame({}, Image(8, 8, 1))), FailsWith(ErrorCode::Unsupported, "grey"));
  Frame cut = make_frame({}, Image(8, 8, 3));
  cut.layout.height = 9;
  EXPECT_THAT(live.key(cut), FailsWith(keyer->key(cut).error().code, ""));
  EXPECT_TRUE(live.key(Frame{})->empty());
}

TEST(ClothKernels, GiveTheSameBitsOnEveryInstructionSet) {
  Random random(5);
  const std::size_t count = 200, whole = padded(count);
  std::vector<std::uint8_t> rgb(3 * count);
  for (std::uint8_t& v : rgb) v = static_cast<std::uint8_t>(random.uniform(0, 256));
  const ClothMeasure measure({40, 120, 60});
  for (const ClothKernels& kernels : all_cloth_kernels()) {
    std::vector<std::uint8_t> r(whole), g(whole), b(whole);
    std::vector<std::uint64_t> subject(whole / 64), faint(whole / 64), doubt(whole / 64);
    std::vector<std::int32_t> steps(whole);
    kernels.split(rgb.data(), count, r.data(), g.data(), b.data());
    kernels.classify(measure, r.data(), g.data(), b.data(), whole, subject.data(), faint.data(),
                     doubt.data());
    kernels.quantize(measure.along, r.data(), g.data(), b.data(), whole, steps.data());
    for (std::size_t x = 0; x < count; ++x) {
      const std::uint8_t* p = rgb.data() + 3 * x;
      const float value = measure.value(p[0], p[1], p[2]);
      ASSERT_EQ(subject[x / 64] >> (x % 64) & 1, value >= 128) << kernels.name;
      ASSERT_EQ(faint[x / 64] >> (x % 64) & 1, value >= 24) << kernels.name;
      ASSERT_EQ(doubt[x / 64] >> (x % 64) & 1, value > measure.doubtful) << kernels.name;
      ASSERT_EQ(steps[x], std::lrint(RowMeasure::kQuantum * measure.along.of(p[0], p[1], p[2])))
          << kernels.name;
    }
  }
}

}  // namespace
}  // namespace floatstage::matting
