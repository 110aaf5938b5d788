#include "detail/quad.h"

#include <gtest/gtest.h>

namespace floatstage::detail {
namespace {

using Eigen::Matrix3d;

Matrix3d matrix(double a, double b, double c, double d, double e, double f, double g = 0, double h = 0) {
  Matrix3d m;
  m << a, b, c, d, e, f, g, h, 1;
  return m;
}

TEST(Quad, OfASimilarityIsItsTurnedRectangle) {
  const std::optional<Quad> quad = sane_quad(matrix(0, -0.5, 100, 0.5, 0, 20), 80, 40);
  ASSERT_TRUE(quad);
  EXPECT_EQ((*quad)[0], Eigen::Vector2d(100, 20));
  EXPECT_EQ((*quad)[2], Eigen::Vector2d(80, 60));
  EXPECT_DOUBLE_EQ(area_of(*quad), 800);
}

TEST(Quad, ThatFoldsIsMirroredLiesBehindOrIsSqueezedIsNone) {
  EXPECT_FALSE(sane_quad(matrix(-1, 0, 50, 0, 1, 0), 50, 50)) << "mirrored";
  EXPECT_FALSE(sane_quad(matrix(1, 0, 0, 0, 1, 0, -0.03, 0), 50, 50)) << "partly behind";
  EXPECT_FALSE(sane_quad(matrix(1, 0, 0, 0, 1, 0, 0.02, 0), 50, 50)) << "one side far larger than the other";
  EXPECT_FALSE(sane_quad(matrix(1, 0, 0, 0, 0.4, 0), 50, 50)) << "squeezed";
  EXPECT_FALSE(sane_quad(Matrix3d::Zero(), 50, 50));
  EXPECT_FALSE(sane_quad(Matrix3d::Constant(NAN), 50, 50));
  EXPECT_TRUE(sane_quad(matrix(1, 0, 0, 0, 0.6, 0, 0.002, 0), 50, 50));
}

TEST(Quad, LiesInAPictureByTheShareOfItsArea) {
  const Quad square = *sane_quad(matrix(1, 0, 0, 0, 1, 0), 10, 10);
  EXPECT_DOUBLE_EQ(share_inside(square, 10, 10), 1);
  EXPECT_DOUBLE_EQ(share_inside(square, 5, 20), 0.5);
  const Quad beside = *sane_quad(matrix(1, 0, 100, 0, 1, 0), 10, 10);
  EXPECT_DOUBLE_EQ(share_inside(beside, 50, 50), 0);
}

}  // namespace
}  // namespace floatstage::detail
