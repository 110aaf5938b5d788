#include "render/cpu/raster.h"

#include <algorithm>
#include <cmath>

#include "core/random.h"
#include "render/closed_mesh.h"
#include "render/cpu/covered.h"
#include "render/cpu/weight_kernels.h"
#include "tests/render/stage.h"

namespace floatstage::render {
namespace {

using render::cpu::Covered;
using render::cpu::RasterCamera;
using render::cpu::ScreenMesh;

/// Looks along +z: pixel = 10 * (x/z, y/z).
RasterCamera ten_pixels(int width, int height) {
  RasterCamera camera;
  camera.rows << 10, 0, 0, 0, 0, 10, 0, 0, 0, 0, 1, 0;
  camera.near_plane = 0.1F;
  camera.far_plane = 100;
  camera.width = width;
  camera.height = height;
  return camera;
}

struct Drawn {
  std::vector<float> inverse_z;
  std::vector<std::uint32_t> triangle;
};

Drawn draw(const Mesh& mesh, const RasterCamera& camera, bool closed = false, int bands = 1) {
  ScreenMesh screen;
  screen.begin(mesh, camera, closed);
  for (std::size_t chunk = 0; chunk < screen.chunks(); ++chunk) screen.project(chunk);
  const auto pixels = static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
  Drawn out{std::vector<float>(pixels, -1), std::vector<std::uint32_t>(pixels, 0)};
  for (int b = 0; b < bands; ++b)
    screen.draw(b * camera.height / bands, (b + 1) * camera.height / bands, out.inverse_z.data(),
                out.triangle.data());
  return out;
}

TEST(Raster, ASampleOnASharedEdgeBelongsToOneTriangle) {
  // A fan around a pixel's centre, with edges through many others.
  Mesh fan;
  fan.positions.push_back({0.45F, 0.45F, 1});
  constexpr int kAround = 8;
  for (int i = 0; i < kAround; ++i)
    fan.positions.push_back({0.45F + 0.4F * static_cast<float>(std::cos(M_PI * i / 4)),
                             0.45F + 0.4F * static_cast<float>(std::sin(M_PI * i / 4)), 1});
  const RasterCamera camera = ten_pixels(9, 9);
  std::vector<int> times(81, 0);
  for (std::uint32_t i = 0; i < kAround; ++i) {
    Mesh one = fan;
    one.triangles = {0, 1 + i, 1 + (i + 1) % kAround};
    const Drawn drawn = draw(one, camera);
    for (std::size_t p = 0; p < 81; ++p) times[p] += drawn.inverse_z[p] > 0;
  }
  for (int y = 0; y < 9; ++y)
    for (int x = 0; x < 9; ++x) {
      EXPECT_LE(times[static_cast<std::size_t>(9 * y + x)], 1) << x << ' ' << y;
      if (std::hypot(x - 4, y - 4) >= 3.5) continue;
      EXPECT_EQ(times[static_cast<std::size_t>(9 * y + x)], 1) << x << ' ' << y;
    }
}

TEST(Raster, DepthIsThatOfThePlane) {
  Mesh slope;  // z = 1 + x
  slope.positions = {{0, 0, 1}, {0, 40, 1}, {40, 0, 41}};
  slope.triangles = {0, 1, 2};
  const Drawn drawn = draw(slope, ten_pixels(9, 9));
  for (int y = 0; y < 9; ++y)
    for (int x = 0; x < 9; ++x) {
      const double u = (x + 0.5) / 10;  // x/z = u and z = 1 + x
      EXPECT_NEAR(drawn.inverse_z[static_cast<std::size_t>(9 * y + x)], 1 - u, 2e-3) << x << ' ' << y;
    }
}

TEST(Raster, TheNearerSurfaceHidesTheFartherOneInAnyOrder) {
  Mesh two;
  for (const float z : {2.F, 1.F})
    for (const auto& [x, y] : {std::pair(-1.F, -1.F), std::pair(-1.F, 9.F), std::pair(9.F, -1.F)})
      two.positions.push_back({x * z, y * z, z});
  for (const bool far_first : {true, false}) {
    two.triangles = far_first ? std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5}
                              : std::vector<std::uint32_t>{3, 4, 5, 0, 1, 2};
    const Drawn drawn = draw(two, ten_pixels(8, 8));
    EXPECT_THAT(drawn.inverse_z, testing::Each(1.F));
    EXPECT_THAT(drawn.triangle, testing::Each(far_first ? 1U : 0U));
  }
}

TEST(Raster, BandsChangeNothing) {
  const Mesh mesh = ball(0.25F, 24);
  RasterCamera camera = ten_pixels(60, 50);
  camera.rows << 80, 0, 30, 30, 0, 80, 25, 25, 0, 0, 1, 1;  // the ball 1 m ahead
  const Drawn one = draw(mesh, camera, true), five = draw(mesh, camera, true, 5);
  EXPECT_EQ(one.inverse_z, five.inverse_z);
  EXPECT_EQ(one.triangle, five.triangle);
}

TEST(Raster, CullingAClosedMeshChangesNoDepth) {
  const Mesh mesh = ball(0.25F, 24);
  RasterCamera camera = ten_pixels(60, 50);
  camera.rows << 80, 0, 30, 30, 0, 80, 25, 25, 0, 0, 1, 1;
  EXPECT_EQ(draw(mesh, camera, true).inverse_z, draw(mesh, camera, false).inverse_z);
}

TEST(Raster, WhatReachesBehindTheEyeIsCut) {
  Mesh floor;  // y = 1, from behind the eye to the distance
  floor.positions = {{-50, 1, -50}, {50, 1, -50}, {50, 1, 90}, {-50, 1, 90}};
  floor.triangles = {0, 1, 2, 0, 2, 3};
  const RasterCamera camera = [] {
    RasterCamera c = ten_pixels(20, 20);
    c.rows.row(0) << 10, 0, 10, 0;
    return c;
  }();
  const Drawn drawn = draw(floor, camera, true);
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 20; ++x)  // y/z = (row + 0.5) / 10, so 1/z is just that
      EXPECT_NEAR(drawn.inverse_z[static_cast<std::size_t>(20 * y + x)], (y + 0.5) / 10, 0.02)
          << x << ' ' << y;
}

TEST(IsClosed, KnowsHolesAndInsideOut) {
  Mesh tetrahedron;
  tetrahedron.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  tetrahedron.triangles = {0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2};
  EXPECT_TRUE(is_closed(tetrahedron));
  Mesh open = tetrahedron;
  open.triangles.resize(9);
  EXPECT_FALSE(is_closed(open));
  Mesh inside_out = tetrahedron;
  for (std::size_t t = 0; t < inside_out.triangles.size(); t += 3)
    std::swap(inside_out.triangles[t], inside_out.triangles[t + 1]);
  EXPECT_FALSE(is_closed(inside_out));
  EXPECT_FALSE(is_closed(Mesh{}));
}

TEST(Covered, ListsEveryCoveredPixelOnce) {
  const std::vector<float> plane = {0, 1, 2, 0, 3, 0, 0, 0, 0, 0, 4, 5, 6, 7, 8};
  Covered covered;
  covered.find(5, 3, plane.data());
  ASSERT_EQ(covered.rows.size(), 3U);
  EXPECT_EQ(covered.rows[0].count, 3);
  EXPECT_EQ(covered.rows[0].last_span - covered.rows[0].first_span, 2U);
  EXPECT_EQ(covered.rows[1].count, 0);
  EXPECT_EQ(covered.rows[2].count, 5);
  EXPECT_EQ(covered.rows[2].list % Covered::kAlign, 0U);
  EXPECT_EQ(covered.x[covered.rows[0].list + 2], 4.5F);
  EXPECT_EQ(covered.inverse_z[covered.rows[2].list + 4], 8);
}

TEST(SoftVisibility, IsTheDistanceToTheNextHiddenPixel) {
  constexpr int kWidth = 70, kHeight = 40, kSlot = 2;
  constexpr float kRadius = 7.5F;
  const int reach = static_cast<int>(std::ceil(kRadius));
  Random random(4);
  std::vector<std::uint8_t> hidden(kWidth * kHeight);
  for (std::uint8_t& h : hidden)
    h = random.uniform() < 0.004 ? 1 << kSlot | 1 : random.uniform() < 0.1 ? 1 : 0;
  std::vector<std::int16_t> squares(kWidth * kHeight);
  std::vector<std::uint8_t> scratch(2 * (kWidth + 2 * static_cast<std::size_t>(reach) + 64));
  std::vector<bool> any(kHeight);
  for (int y = 0; y < kHeight; ++y)
    any[static_cast<std::size_t>(y)] = render::cpu::row_distances(
        hidden.data() + y * kWidth, kWidth, kSlot, reach, scratch.data(), squares.data() + y * kWidth);
  for (int y = 0; y < kHeight; ++y) {
    std::vector<const std::int16_t*> rows;
    std::vector<std::int16_t> offsets;
    for (int v = std::max(0, y - reach); v <= std::min(kHeight - 1, y + reach); ++v)
      if (any[static_cast<std::size_t>(v)]) {
        rows.push_back(squares.data() + v * kWidth);
        offsets.push_back(static_cast<std::int16_t>((v - y) * (v - y)));
      }
    std::vector<float> shares(kWidth);
    render::cpu::soft_shares(rows.data(), offsets.data(), static_cast<int>(rows.size()), kRadius, kWidth,
                             shares.data());
    for (int x = 0; x < kWidth; ++x) {
      double nearest = 1e9;
      for (int v = 0; v < kHeight; ++v)
        for (int u = 0; u < kWidth; ++u)
          if ((hidden[static_cast<std::size_t>(v * kWidth + u)] >> kSlot & 1) != 0)
            nearest = std::min(nearest, std::hypot(u - x, v - y));
      ASSERT_NEAR(shares[static_cast<std::size_t>(x)], std::min(nearest / static_cast<double>(kRadius), 1.0),
                  1e-5)
          << x << ' ' << y;
    }
  }
}

}  // namespace
}  // namespace floatstage::render
