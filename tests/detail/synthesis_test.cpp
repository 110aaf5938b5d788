#include "detail/synthesis/synthesis.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/file.h"
#include "core/random.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::detail {
namespace {

constexpr int kLevels = 3, kWidth = 37, kHeight = 29;

// Hatching whose direction and tone change slowly.
Image hatched(const Region& r) {
  Image out(r.width(), r.height(), 4, 255);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      const double u = x + r.x0, v = y + r.y0;
      const double wave = std::sin(0.9 * u + 0.4 * v + 3 * std::sin(u / 60)) + std::sin(0.21 * v - 0.1 * u);
      for (int c = 0; c < 3; ++c)
        out.at(x, y)[c] =
            static_cast<std::uint8_t>(std::lround(120 + 25 * c + 35 * wave + 20 * std::sin(v / 50)));
    }
  return out;
}

Image root_picture() {
  const Image fine = hatched({0, 0, kWidth << kLevels, kHeight << kLevels});
  Image out(kWidth, kHeight, 3);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      for (int c = 0; c < 3; ++c) {
        int sum = 0;
        for (int i = 0; i < 64; ++i) sum += fine.at(8 * x + i % 8, 8 * y + i / 8)[c];
        out.at(x, y)[c] = static_cast<std::uint8_t>((sum + 32) / 64);
      }
  return out;
}

Synthesis make(int threads = 1) {
  const Region r{70, 50, 198, 162};
  SynthesisOptions options;
  options.levels = kLevels;
  options.threads = threads;
  Result<Synthesis> made =
      Synthesis::make(root_picture(), {{hatched(r), r.x0, r.y0, kLevels, false}}, options);
  EXPECT_THAT(made, IsOk());
  return *made;
}

TEST(ASynthesis, IsTheSameInTilesOfAnySizeAndAtAnyNumberOfThreads) {
  const Synthesis one = make(1), two = make(2);
  const SynthesisTile whole = one.tile({0, 0, one.width(), one.height()});
  for (const Region r :
       {Region{0, 0, 64, 64}, Region{61, 33, 140, 97}, Region{200, 150, 296, 232}, Region{5, 5, 6, 6}}) {
    const SynthesisTile tile = two.tile(r);
    for (int y = r.y0; y < r.y1; ++y)
      for (int x = r.x0; x < r.x1; ++x) {
        ASSERT_EQ(tile.colors.at(x, y), whole.colors.at(x, y)) << x << " " << y;
        ASSERT_EQ(tile.provenance.at(x, y), whole.provenance.at(x, y));
      }
  }
}

TEST(ASynthesis, HasTheRootsMeansAndThePhotographsPixels) {
  const Synthesis synthesis = make();
  const SynthesisTile whole = synthesis.tile({0, 0, synthesis.width(), synthesis.height()});
  const Image root = root_picture(), truth = hatched(whole.region);
  std::array<int, 4> count{};
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      bool made = true;
      double sum = 0;
      for (int i = 0; i < 64; ++i) {
        const int u = 8 * x + i % 8, v = 8 * y + i / 8;
        const std::uint8_t from = whole.provenance.at(u, v);
        ++count[from];
        made = made && from <= static_cast<std::uint8_t>(Provenance::Synthesised);
        sum += whole.colors.at(u, v)[1] / 64;
        if (from == static_cast<std::uint8_t>(Provenance::Real)) {
          EXPECT_EQ(whole.colors.at(u, v)[1], truth.at(u, v)[1]) << u << " " << v;
        }
      }
      if (made) {
        EXPECT_NEAR(sum, root.at(x, y)[1], 0.01) << x << " " << y;
      }
    }
  EXPECT_EQ(whole.colors.at(130, 100)[1], truth.at(130, 100)[1]);
  EXPECT_GT(count[static_cast<std::size_t>(Provenance::Real)], 9000);
  EXPECT_GT(count[static_cast<std::size_t>(Provenance::Synthesised)], 40000);
}

// compose() lays a photograph over its parent as opaque as the gradients up to its seam say: seldom wholly.
TEST(ASynthesis, UsesWholeWhatFadesInSlowly) {
  const Region r{70, 50, 198, 162};
  DetailLayer fading{hatched(r), r.x0, r.y0, kLevels, false};
  for (int y = 0; y < fading.picture.height; ++y)
    for (int x = 0; x < fading.picture.width; ++x)
      fading.picture.at(x, y)[3] = static_cast<std::uint8_t>(40 + 160 * x / fading.picture.width);
  const int first = 36;  // of its columns that is opaque to a third
  SynthesisOptions options;
  options.levels = kLevels;
  const Result<Synthesis> made = Synthesis::make(root_picture(), {fading}, options);
  ASSERT_THAT(made, IsOk());
  const SynthesisTile tile = made->tile(r);
  const Image truth = hatched(r);
  const auto from = [&](int x, int y) { return static_cast<Provenance>(tile.provenance.at(x, y)); };
  const int y = (r.y0 + r.y1) / 2, rim = 8;
  for (int x = r.x0; x < r.x0 + first - 1; ++x) EXPECT_EQ(from(x, y), Provenance::Synthesised) << x;
  for (int x = r.x0 + first + rim; x < r.x1 - rim; ++x) {
    EXPECT_EQ(from(x, y), Provenance::Real) << x;
    EXPECT_EQ(tile.colors.at(x, y)[1], truth.at(x - r.x0, y - r.y0)[1]) << x;
  }
}

TEST(ASynthesis, HasMoreDetailsThanARootThatIsOnlyEnlarged) {
  SynthesisOptions options;
  options.levels = kLevels;
  const Result<Synthesis> bare = Synthesis::make(root_picture(), {}, options);
  ASSERT_THAT(bare, IsOk());
  const Region r{210, 20, 280, 200};
  const auto contrast = [&](const SynthesisTile& tile) {
    double sum = 0;
    for (int y = r.y0; y < r.y1; ++y)
      for (int x = r.x0 + 1; x < r.x1; ++x)
        sum += std::abs(tile.colors.at(x, y)[1] - tile.colors.at(x - 1, y)[1]);
    return sum / (r.width() * r.height());
  };
  const SynthesisTile enlarged = bare->tile(r);
  EXPECT_EQ(enlarged.provenance.at(220, 100), static_cast<std::uint8_t>(Provenance::Upsampled));
  EXPECT_GT(contrast(make().tile(r)), 2 * contrast(enlarged));
}

TEST(ASynthesis, SaysWhatItCannotWorkOn) {
  SynthesisOptions options;
  EXPECT_THAT(Synthesis::make(Image(), {}, options), FailsWith(ErrorCode::InvalidArgument, "three channels"));
  options.levels = 7;
  EXPECT_THAT(Synthesis::make(Image(4, 4, 3), {}, options),
              FailsWith(ErrorCode::InvalidArgument, "1 to 6 levels"));
  options.levels = 2;
  EXPECT_THAT(Synthesis::make(Image(4, 4, 3), {{Image(8, 8, 4), 10, 0, 2, false}}, options),
              FailsWith(ErrorCode::InvalidArgument, "inside the picture"));
}

TEST(ASynthesis, OfOnePixelAndATinyPhotographIsAPicture) {
  SynthesisOptions options;
  options.levels = 2;
  const Result<Synthesis> made =
      Synthesis::make(Image(1, 1, 3, 90), {{Image(2, 2, 4, 255), 1, 1, 2, false}}, options);
  ASSERT_THAT(made, IsOk());
  EXPECT_EQ(made->tile({0, 0, 4, 4}).colors.at(0, 0)[0], 90);
}

}  // namespace
}  // namespace floatstage::detail
