// A child that was moved, brightened and bent in its tones comes out as its parent would have shown it: truth
// is made.

#include "detail/transfer.h"

#include <algorithm>
#include <numbers>
#include <numeric>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/detail/pictures.h"

namespace floatstage::detail {
namespace {

using Eigen::Vector2d;

constexpr int kWidth = 360, kHeight = 270;

/// Bent stripes of three colours that cross the whole picture, as planks and cables do, and a fine grain: no
/// seam avoids them.
Eigen::Vector3d patches(double x, double y) {
  const Eigen::Vector3d grain = test::world(x, y, 9, 2);
  const auto stripe = [](double t, double period, double edge) {  // 0 to 1 over `edge` px, and back
    const double phase = t / period - std::floor(t / period);
    const double near = period * (0.25 - std::abs(phase - 0.5));
    return 1 / (1 + std::exp(-near * 4 / edge));
  };
  Eigen::Vector3d color(0.25, 0.3, 0.2);
  color += stripe(y + 9 * std::sin(x / 31), 74, 2) * Eigen::Vector3d(0.35, 0.2, 0.1);
  color += stripe(x + 12 * std::sin(y / 43), 83, 2) * Eigen::Vector3d(-0.1, 0.1, 0.35);
  return color + 0.12 * (grain - Eigen::Vector3d::Constant(0.5));
}

/// Where a child's pixel really lies: up to `most` px off, smoothly.
Vector2d moved(const Vector2d& p, double most) {
  const double a = 2 * std::numbers::pi / kWidth, b = 2 * std::numbers::pi / kHeight;
  return p + most / std::sqrt(2.0) *
                 Vector2d(std::sin(1.3 * a * p.x() + b * p.y() + 0.4), std::cos(a * p.x() - 1.1 * b * p.y()));
}

// What an exposure, a white balance and another gamma make of encoded values.
Eigen::Vector3d other_tones(const Eigen::Vector3d& c) {
  return {0.85 * std::pow(c[0], 1.15), 1.1 * std::pow(c[1], 1.1), 0.95 * std::pow(c[2], 0.85)};
}

template <class Color>
LightPicture picture(int width, int height, const Color& color) {
  Image out(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const Eigen::Vector3d c = color(Vector2d(x + 0.5, y + 0.5));
      for (int k = 0; k < 3; ++k)
        out.at(x, y)[k] = static_cast<std::uint8_t>(std::lround(255 * std::clamp(c[k], 0.0, 1.0)));
    }
  return to_light(out);
}

LightPicture parent_picture() {
  return picture(kWidth, kHeight, [](const Vector2d& p) { return patches(p.x(), p.y()); });
}

LightPicture child_picture(double most) {
  return picture(kWidth, kHeight, [&](const Vector2d& p) {
    const Vector2d at = moved(p, most);
    return other_tones(patches(at.x(), at.y()));
  });
}

Vector2d place_shown(const Transfer& t, int x, int y, double most) {
  Vector2d p(x + 0.5, y + 0.5);
  if (t.adapted) {
    const Light& d = t.structure.displacement.at(x, y);
    p += Vector2d(static_cast<double>(d[0]), static_cast<double>(d[1]));
  }
  return moved(p, most);
}

// How far the child's edges lie from the parent's where they cross the seam, across the edge, px; mean.
double edge_offset(const Transfer& t, const LightPicture& parent, const std::vector<std::uint8_t>& seam,
                   double most) {
  double sum = 0;
  int count = 0;
  const auto value = [&](int x, int y) { return static_cast<double>(encoded(parent.at(x, y)[1])); };
  for (int y = 1; y + 1 < kHeight; ++y)
    for (int x = 1; x + 1 < kWidth; ++x) {
      const std::size_t i = parent.index(x, y);
      if (seam[i] == 0 ||
          (seam[i - 1] != 0 && seam[i + 1] != 0 && seam[i - kWidth] != 0 && seam[i + kWidth] != 0))
        continue;
      const Vector2d slope(value(x + 1, y) - value(x - 1, y), value(x, y + 1) - value(x, y - 1));
      if (slope.norm() < 0.06) continue;
      sum += std::abs((place_shown(t, x, y, most) - Vector2d(x + 0.5, y + 0.5)).dot(slope.normalized()));
      ++count;
    }
  EXPECT_GT(count, 10);
  return sum / count;
}

// Steps of 255 between the child's colours and what the parent's camera would have made of the same place;
// mean.
double color_error(const Transfer& t, double most) {
  double sum = 0;
  int count = 0;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      if (t.seam.child[t.adjusted.index(x, y)] == 0) continue;
      const Vector2d at = place_shown(t, x, y, most);
      const Eigen::Vector3d truth = patches(at.x(), at.y());
      for (std::size_t k = 0; k < 3; ++k) {
        sum += std::abs(255 * static_cast<double>(encoded(t.adjusted.at(x, y)[k])) -
                        255 * truth[static_cast<Eigen::Index>(k)]);
        ++count;
      }
    }
  return sum / count;
}

TEST(TransferredDetail, LosesItsOwnTones) {
  const Transfer t = transfer_detail(child_picture(0), parent_picture(), 1);
  EXPECT_LE(color_error(t, 0), 1.5);
  EXPECT_GT(std::accumulate(t.seam.child.begin(), t.seam.child.end(), 0), kWidth * kHeight / 2);
}

TEST(TransferredDetail, ThatIsUpToSixPixelsOffMeetsItsParentsEdgesAlongTheSeam) {
  const LightPicture parent = parent_picture();
  for (const double most : {2.0, 4.0, 6.0}) {
    const LightPicture child = child_picture(most);
    const Transfer t = transfer_detail(child, parent, 1),
                   unmoved = transfer_detail(child, parent, 1, {false});
    EXPECT_TRUE(t.adapted);
    EXPECT_LE(edge_offset(t, parent, t.seam.child, most), 0.5) << most;
    EXPECT_GT(edge_offset(unmoved, parent, unmoved.seam.child, most), 0.5) << "nothing was to be done";
    EXPECT_LE(color_error(t, most), 1.5) << most;
    EXPECT_LT(t.seam_cost, 0.7 * t.first_seam.energy) << "a third of what is seen of the seam is gone";
  }
}

TEST(TransferredDetail, LeavesToTheParentWhatItDoesNotShow) {
  const LightPicture parent = parent_picture();
  LightPicture child = child_picture(0);
  for (int y = 100; y < 150; ++y)
    for (int x = 150; x < 200; ++x) child.at(x, y) = {0.9F, 0.05F, 0.02F, 0};  // a red flag
  for (const bool adapt : {true, false}) {
    const Transfer t = transfer_detail(child, parent, 1, {adapt});
    for (int y = 110; y < 140; ++y)
      for (int x = 160; x < 190; ++x) ASSERT_EQ(t.alpha.at(x, y), 0) << x << " " << y;
    EXPECT_GT(t.alpha.at(280, 135), 0.5F);
    EXPECT_LE(color_error(t, 0), 1.5) << "the flag's colour does not spread";
  }
}

TEST(TransferredDetail, IsOpaqueInsideAndClearAtItsRim) {
  const Transfer t = transfer_detail(child_picture(0), parent_picture(), 1);
  for (int x = 0; x < kWidth; ++x) {
    EXPECT_EQ(t.alpha.at(x, 0), 0);
    EXPECT_EQ(t.alpha.at(x, kHeight - 1), 0);
  }
  EXPECT_EQ(t.alpha.at(kWidth / 2, kHeight / 2), 1);
  for (const float a : t.alpha.values) ASSERT_TRUE(a >= 0 && a <= 1);
}

TEST(TransferredDetail, OfPicturesWithoutAnyFeatureIsThePictureItself) {
  const LightPicture flat = picture(80, 60, [](const Vector2d&) { return Eigen::Vector3d(0.4, 0.5, 0.6); });
  const Transfer t = transfer_detail(flat, flat, 2);
  EXPECT_FALSE(t.adapted);
  for (std::size_t i = 0; i < flat.pixels.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) ASSERT_NEAR(t.adjusted.pixels[i][k], flat.pixels[i][k], 2e-3);
}

}  // namespace
}  // namespace floatstage::detail
