#include "matting/refine_edges.h"

#include <cmath>

#include <gtest/gtest.h>

namespace floatstage::matting {
namespace {

// A dark subject on the left of column `edge`, which it covers by `share`; the measure is 100 on the cloth.
struct HalfPlane {
  int edge = 30;
  double share = 0.3;
  float subject = 0, cloth = 100;

  float measure(int x) const {
    const double a = x < edge ? 1 : x == edge ? share : 0;
    return static_cast<float>(a * subject + (1 - a) * cloth);
  }
  // A key that knows only sides, and errs by `offset` columns.
  Image key(int offset = 0) const {
    Image alpha(64, 32, 1);
    for (int y = 0; y < 32; ++y)
      for (int x = 0; x < edge + offset; ++x) *alpha.at(x, y) = 255;
    return alpha;
  }
  Image refined(Image alpha, const Image& doubt = Image(64, 32, 1), float contrast = 5) const {
    refine_edges(
        [this](int, int x0, int count, float* out) {
          for (int x = x0; x < x0 + count; ++x) *out++ = measure(x);
        },
        contrast, doubt, alpha);
    return alpha;
  }
};

TEST(RefineEdges, SolvesTheShareOfAMixedPixelHoweverTheKeyErred) {
  for (double share : {0.1, 0.5, 0.8}) {
    for (int offset : {-1, 0, 1, 2}) {
      const HalfPlane plane{.share = share};
      const Image alpha = plane.refined(plane.key(offset));
      EXPECT_EQ(*alpha.at(29, 16), 255) << share << ' ' << offset;
      EXPECT_NEAR(*alpha.at(30, 16), 255 * share, 1) << share << ' ' << offset;
      EXPECT_EQ(*alpha.at(31, 16), 0) << share << ' ' << offset;
    }
  }
}

TEST(RefineEdges, UsesTheSubjectsOwnMeasure) {
  const HalfPlane plane{.share = 0.5, .subject = 40};  // spill
  EXPECT_NEAR(*plane.refined(plane.key()).at(30, 16), 128, 1);
}

TEST(RefineEdges, KeepsTheKeyWhereTheSidesLookAlike) {
  const HalfPlane plane{.subject = 97};
  EXPECT_EQ(plane.refined(plane.key()), plane.key());
}

TEST(RefineEdges, MakesTheInsideOpaque) {
  HalfPlane plane;
  Image key = plane.key();
  for (int y = 10; y < 20; ++y) *key.at(10, y) = 150;
  EXPECT_EQ(*plane.refined(key).at(10, 15), 255);
}

TEST(RefineEdges, FindsAHairThatHangsTogetherWithTheSubjectByItsDoubt) {
  Image key(64, 48, 1), doubt(64, 48, 1);
  for (int y = 30; y < 48; ++y)
    for (int x = 20; x < 44; ++x) *key.at(x, y) = 255;
  for (int y = 10; y < 30; ++y) *doubt.at(32, y) = *doubt.at(50, y) = 255;
  auto measure = [](int y, int x0, int count, float* out) {
    for (int x = x0; x < x0 + count; ++x) {
      const bool subject = y >= 30 && x >= 20 && x < 44, hair = y >= 10 && y < 30 && (x == 32 || x == 50);
      *out++ = subject ? 0.0f : hair ? 30.0f : 100.0f;
    }
  };
  refine_edges(measure, 5, doubt, key);
  EXPECT_NEAR(*key.at(32, 14), 255 * 0.7, 1);
  EXPECT_EQ(*key.at(50, 14), 0) << "this one is nobody's";
  EXPECT_EQ(*key.at(34, 14), 0);
}

TEST(RefineEdges, LeavesAnEmptyAndAFullMatteAlone) {
  const HalfPlane plane;
  EXPECT_EQ(plane.refined(Image(64, 32, 1)), Image(64, 32, 1));
  EXPECT_EQ(plane.refined(Image(64, 32, 1, 255)), Image(64, 32, 1, 255));
}

}  // namespace
}  // namespace floatstage::matting
