#include <cmath>

#include <gtest/gtest.h>

#include "core/random.h"
#include "recon/exact/exact_integer.h"
#include "recon/exact/exact_polygon.h"
#include "recon/exact/line_relations.h"
#include "tests/recon/cone_views.h"

namespace floatstage::recon {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

Int128 random_bits(Random& random, int bits) {
  const Int128 value = static_cast<Int128>(static_cast<UInt128>(random.next()) << 64 | random.next());
  return value >> (128 - bits);
}

TEST(ExactInteger, KnowsTheSignOfProductsThatDifferByOne) {
  Random random(1);
  for (int k = 0; k < 1000; ++k) {
    const Int128 a = random_bits(random, 1 + k % 120), b = random_bits(random, 1 + (k * 7) % 120);
    const Wide square = Wide(a) * Wide(a) - Wide(b) * Wide(b);
    // (a + b)(a - b) = a² - b², and one more or less changes the sign of the difference.
    EXPECT_EQ((square - (Wide(a) + Wide(b)) * (Wide(a) - Wide(b))).sign(), 0);
    const Wide far = Wide(a) * Wide(b) * Wide(static_cast<Int128>(1) << 100);
    EXPECT_EQ((far + Wide(1) - far).sign(), 1);
    EXPECT_EQ((far - Wide(1) - far).sign(), -1);
    EXPECT_EQ((-far).sign(), -far.sign());
  }
}

TEST(ExactInteger, HoldsTheLargestPredicateOfTheSweep) {
  const Wide big = Wide(static_cast<Int128>(1) << 88) * Wide(static_cast<Int128>(1) << 87);  // 2^175
  EXPECT_EQ((big * big - big * (big - Wide(1))).sign(), 1);
  EXPECT_EQ((big * (-big) + big * big).sign(), 0);
}

double area_of(const std::vector<Vector2d>& points, const std::vector<std::int32_t>& triangles) {
  double sum = 0;
  for (std::size_t t = 0; t < triangles.size(); t += 3) {
    const Vector2d a = points[triangles[t]], b = points[triangles[t + 1]], c = points[triangles[t + 2]];
    const double twice = (c.x() - a.x()) * (b.y() - a.y()) - (b.x() - a.x()) * (c.y() - a.y());
    EXPECT_GT(twice, -1e-12) << "a triangle is upside down";
    sum += twice / 2;
  }
  return sum;
}

std::vector<Vector2d> star(int corners, double inner, double outer, double turn = 0) {
  std::vector<Vector2d> out;
  for (int k = 0; k < corners; ++k) {
    const double a = turn - 2 * M_PI * k / corners, r = k % 2 ? inner : outer;
    out.push_back(r * Vector2d(std::cos(a), std::sin(a)));
  }
  return out;
}

double star_area(int corners, double inner, double outer) {
  return corners * 0.5 * inner * outer * std::sin(2 * M_PI / corners);
}

TEST(PolygonCutter, CoversStarsExactly) {
  PolygonCutter cutter;
  for (const int corners : {4, 6, 10, 30}) {
    const auto points = star(corners, 0.3, 1);
    std::vector<std::int32_t> triangles;
    cutter.cut(points, std::vector<std::int32_t>{corners}, triangles);
    EXPECT_EQ(triangles.size() / 3, static_cast<std::size_t>(corners) - 2);
    EXPECT_NEAR(area_of(points, triangles), star_area(corners, 0.3, 1), 1e-12);
  }
}

TEST(PolygonCutter, LeavesHolesOpen) {
  PolygonCutter cutter;
  std::vector<Vector2d> points = star(12, 0.8, 1);
  std::vector<std::int32_t> ends = {12};
  double expected = star_area(12, 0.8, 1);
  for (const Vector2d& at : {Vector2d(0.4, 0), Vector2d(-0.3, 0.3), Vector2d(-0.3, -0.3)}) {
    auto hole = star(6, 0.1, 0.2, 0.3);
    std::reverse(hole.begin(), hole.end());
    for (const Vector2d& p : hole) points.push_back(at + p);
    ends.push_back(static_cast<std::int32_t>(points.size()));
    expected -= star_area(6, 0.1, 0.2);
  }
  std::vector<std::int32_t> triangles;
  cutter.cut(points, ends, triangles);
  EXPECT_EQ(triangles.size() / 3, points.size() + 2 * 3 - 2);
  EXPECT_NEAR(area_of(points, triangles), expected, 1e-12);
}

TEST(PolygonCutter, TakesSeveralOutlinesEachWithItsHole) {
  PolygonCutter cutter;
  std::vector<Vector2d> points;
  std::vector<std::int32_t> ends;
  for (const double x : {0.0, 5.0}) {
    for (const Vector2d& p : star(8, 0.9, 1)) points.push_back(Vector2d(x, 0) + p);
    ends.push_back(static_cast<std::int32_t>(points.size()));
  }
  for (const double x : {5.0, 0.0}) {
    auto hole = star(4, 0.5, 0.5);
    std::reverse(hole.begin(), hole.end());
    for (const Vector2d& p : hole) points.push_back(Vector2d(x, 0) + p);
    ends.push_back(static_cast<std::int32_t>(points.size()));
  }
  std::vector<std::int32_t> triangles;
  cutter.cut(points, ends, triangles);
  EXPECT_NEAR(area_of(points, triangles), 2 * (star_area(8, 0.9, 1) - star_area(4, 0.5, 0.5)), 1e-12);
}

TEST(PolygonCutter, AlwaysGivesAllTrianglesEvenForFlatPolygons) {
  PolygonCutter cutter;
  for (const int corners : {3, 4, 5, 9}) {
    std::vector<Vector2d> points(static_cast<std::size_t>(corners), Vector2d(1, 2));
    std::vector<std::int32_t> triangles;
    cutter.cut(points, std::vector<std::int32_t>{corners}, triangles);
    EXPECT_EQ(triangles.size() / 3, static_cast<std::size_t>(corners) - 2);
  }
}

TEST(ExactViews, RoundToAGridWithoutMovingMuch) {
  std::vector<ConeView> views;
  for (const Vector3d& center : cones::around(5, 3)) views.push_back(cones::of_sphere(center, 0.5, 20));
  const std::vector<ConeView> before = views;
  GridViews grid;
  ASSERT_TRUE(snap_to_grid(views, grid));
  for (std::size_t v = 0; v < views.size(); ++v) {
    EXPECT_LT((views[v].center - before[v].center).norm(), 1e-7);
    for (std::size_t r = 0; r < views[v].rays.size(); ++r) {
      EXPECT_LT((views[v].rays[r] - before[v].rays[r]).norm(), 1e-8)
          << "1e-5 px at a focal length of 1000 px";
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_LE(std::abs(grid.rays[v][r][axis]), std::int64_t{1} << 28);
        EXPECT_EQ(static_cast<double>(grid.rays[v][r][axis]) / grid.ray_scale, views[v].rays[r][axis]);
      }
    }
  }
  views[1].center = views[0].center;
  EXPECT_FALSE(snap_to_grid(views, grid)) << "two cameras in one place";
}

TEST(ExactViews, MoveTheSameWayForTheSameSeed) {
  std::vector<ConeView> a = {cones::of_sphere({3, 0, 0}, 0.5, 20)}, b = a, c = a;
  const std::vector<ConeView> original = a;
  perturb(a, {5, 1e-6, 1e-6});
  perturb(b, {5, 1e-6, 1e-6});
  perturb(c, {6, 1e-6, 1e-6});
  EXPECT_EQ(a[0].rays, b[0].rays);
  EXPECT_NE(a[0].rays, c[0].rays);
  for (std::size_t r = 0; r < 20; ++r) {
    EXPECT_LE((a[0].rays[r] - original[0].rays[r]).cwiseAbs().maxCoeff(), 1e-6);
    EXPECT_NE(a[0].rays[r], original[0].rays[r]);
  }
}

TEST(ExactViews, OfAVolumeBoundABodyThatContainsTheBox) {
  const Eigen::AlignedBox3d box(Vector3d(-1, -0.5, 0), Vector3d(1, 0.5, 2));
  std::vector<ConeView> views;
  for (ConeView& view : volume_views(box)) views.push_back(std::move(view));
  ExactHull engine;
  ASSERT_TRUE(engine.compute(views, {}).closed);
  Eigen::AlignedBox3d bounds;
  for (const Vector3d& p : engine.polygons().positions) bounds.extend(p);
  EXPECT_TRUE(bounds.contains(box));
  EXPECT_GT(engine.polygons().volume, box.volume());
  EXPECT_LT(engine.polygons().volume, 1.1 * box.volume());
}

// One line at a time, in words: what a block says in vectors.
BlockRelation related_plainly(const LineBlock& block, const CutLine& cut) {
  BlockRelation out{0, 0, 0};
  for (int k = 0; k < LineBlock::kLines; ++k) {
    const auto bit = [&](std::uint8_t bits) { return (bits >> k & 1) != 0; };
    const double from = std::max(cut.entry, block.left[k]), to = std::min(cut.right, block.right[k]);
    const double at_a = cut.wa - block.wa[k], change = cut.wb - block.wb[k] - at_a;
    const bool below_first = at_a + change * from < 0, below_last = at_a + change * to < 0;
    if (below_last) out.falls_below |= static_cast<std::uint8_t>(1 << k);
    if (!bit(block.used)) continue;
    const bool begun = !(cut.entry < block.left[k]), spans = begun && cut.entry < block.right[k];
    const bool under = block.low[k] > cut.high, mixed = from < to && !under && !(block.high[k] < cut.low);
    const int sign = bit(block.upper) ? 1 : -1;
    if (spans && (under || (mixed && below_first))) out.change += sign;
    if (begun && !spans && bit(block.right_above)) out.change += sign;
    if (begun && bit(block.left_above)) out.change -= sign;
    if (mixed && below_first != below_last) out.crosses |= static_cast<std::uint8_t>(1 << k);
  }
  return out;
}

TEST(LineRelations, AreTheSameOnEveryInstructionSetAsOneByOne) {
  Random random(5);
  const std::vector<RelateKernel> kernels = all_relate_kernels();
  ASSERT_FALSE(kernels.empty());
  int crossings = 0;
  for (int round = 0; round < 2000; ++round) {
    // Steps of an eighth: ends that coincide, lines through one point and lines that are one are common.
    const auto step = [&] { return static_cast<double>(random.next() % 17) / 8; };
    LineBlock block{};
    for (int k = 0; k < LineBlock::kLines; ++k) {
      block.wa[k] = step();
      block.wb[k] = step();
      block.left[k] = step() / 2;
      block.right[k] = block.left[k] + step() / 2;
      block.low[k] = std::min(block.wa[k], block.wb[k]);
      block.high[k] = std::max(block.wa[k], block.wb[k]);
    }
    block.used = static_cast<std::uint8_t>(random.next());
    for (std::uint8_t* bits : {&block.upper, &block.left_above, &block.right_above})
      *bits = static_cast<std::uint8_t>(random.next()) & block.used;
    const double entry = step() / 2, wa = step(), wb = step();
    const CutLine cut{wa, wb, entry, entry + step() / 2, std::min(wa, wb), std::max(wa, wb)};
    const BlockRelation plain = related_plainly(block, cut);
    crossings += plain.crosses != 0;
    for (const RelateKernel& kernel : kernels) {
      const BlockRelation fast = kernel.relate(block, cut);
      ASSERT_EQ(fast.change, plain.change) << kernel.name << ", round " << round;
      ASSERT_EQ(fast.crosses, plain.crosses) << kernel.name << ", round " << round;
      ASSERT_EQ(fast.falls_below, plain.falls_below) << kernel.name << ", round " << round;
    }
  }
  EXPECT_GT(crossings, 200);
}

}  // namespace
}  // namespace floatstage::recon
