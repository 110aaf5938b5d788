// Where "floating" puts what its photographs show at different places.
#include <algorithm>

#include "render/cpu/covered.h"
#include "render/cpu/position_kernels.h"
#include "tests/render/stage.h"

namespace floatstage::render {
namespace {

constexpr int kCameras = 3;
using Weights = std::array<float, kCameras>;

// A point of a slanted surface before a view that looks along z, and cameras about it.
struct Corner {
  cpu::ViewRays rays{};
  std::array<Eigen::Vector3f, kCameras> centers;
  Eigen::Vector3f normal = Eigen::Vector3f(0.3F, -0.2F, -1).normalized();
  float x = 210, y = 90, z = 2;

  Corner() : centers{Eigen::Vector3f(-0.5F, 0.1F, 0), {0.4F, 0.3F, 0.1F}, {0.1F, -0.4F, -0.1F}} {
    rays.inverse_fx = 1 / 400.F;
    rays.inverse_fy = 1 / 410.F;
    rays.cx = 160;
    rays.cy = 120;
    rays.world_from_view = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  }
  Eigen::Vector3f ray() const {
    return {(x - rays.cx) * rays.inverse_fx, (y - rays.cy) * rays.inverse_fy, 1};
  }

  Weights weights(const Weights& angular) const {
    Row row(*this, angular);
    cpu::position_weights(rays, row.in_view, row.row);
    return {row.share[0][0], row.share[1][0], row.share[2][0]};
  }

  using Places = std::array<Eigen::Vector2f, kCameras>;
  // Where the cameras' images are read, from the pixel, once `from` leans on what one depth explains; under
  // position weights `follow` and angular ones `pull`.
  Places leaned(const Places& from, const Weights& follow, const Weights& pull) const {
    Row row(*this, follow), pulls(*this, pull);
    cpu::FetchedRow fetched;
    std::array<Lane, kCameras> from_x, from_y;
    for (std::size_t j = 0; j < kCameras; ++j) {
      from_x[j].fill(x + from[j].x());
      from_y[j].fill(y + from[j].y());
      fetched.pull[j] = pulls.share[j].data();
      fetched.from_x[j] = from_x[j].data();
      fetched.from_y[j] = from_y[j].data();
    }
    cpu::lean_on_depth(rays, row.in_view, row.row, fetched);
    Places places;
    for (std::size_t j = 0; j < kCameras; ++j) places[j] = {from_x[j][0] - x, from_y[j][0] - y};
    return places;
  }
  // px of the view
  Places parallaxes(float depth) const {
    Places u;
    for (std::size_t j = 0; j < kCameras; ++j)
      u[j] = displaced(j, depth).cwiseQuotient(Eigen::Vector2f(rays.inverse_fx, rays.inverse_fy));
    return u;
  }

  // Where camera j's photograph, laid on the surface, shows what is there when the surface lies `depth`
  // further along the viewing ray: in the view, from where it is.
  Eigen::Vector2f displaced(std::size_t j, float depth) const {
    const Eigen::Vector3f at = ray() * z, there = ray() * (z + depth);
    const Eigen::Vector3f along = at - centers[j];
    const Eigen::Vector3f seen = at + along * normal.dot(there - at) / normal.dot(along);
    return seen.head<2>() / seen.z() - ray().head<2>();
  }

 private:
  using Lane = std::array<float, cpu::Covered::kAlign>;
  // The point as a row of one pixel.
  struct Row {
    Lane at_x, inverse_z, nx, ny, nz;
    std::array<Lane, kCameras> share;
    cpu::CentersInView in_view{};
    cpu::PositionRow row;

    Row(const Corner& c, const Weights& weights) {
      at_x.fill(c.x);
      inverse_z.fill(1 / c.z);
      nx.fill(c.normal.x());
      ny.fill(c.normal.y());
      nz.fill(c.normal.z());
      row = {1, kCameras, at_x.data(), c.y, inverse_z.data(), {nx.data(), ny.data(), nz.data()}, {}};
      for (std::size_t j = 0; j < kCameras; ++j) {
        share[j].fill(weights[j]);
        row.share[j] = share[j].data();
        in_view[j] = {c.centers[j].x(), c.centers[j].y(), c.centers[j].z()};
      }
    }
  };
};

TEST(PositionWeights, CancelTheParallaxesOfAWrongDepth) {
  const Corner corner;
  const Weights angular = {0.5F, 0.3F, 0.2F}, weights = corner.weights(angular);
  Eigen::Vector2f placed = Eigen::Vector2f::Zero(), before = placed;
  float sum = 0, largest = 0;
  for (std::size_t j = 0; j < kCameras; ++j) {
    const Eigen::Vector2f u = corner.displaced(j, 1e-2F);
    placed += weights[j] * u;
    before += angular[j] * u;
    largest = std::max(largest, u.norm());
    sum += weights[j];
    EXPECT_GT(weights[j], 0);
  }
  EXPECT_NEAR(sum, 1, 1e-5);
  EXPECT_GT(before.norm(), 0.15F * largest) << "nothing is tested";
  EXPECT_LT(placed.norm(), 0.1F * before.norm());  // 2 % of the trace, and a depth that is not small
}

TEST(PositionWeights, StayWhereTheyCancelAlready) {
  Corner corner;
  corner.normal = {0, 0, -1};
  corner.x = corner.rays.cx;
  corner.y = corner.rays.cy;
  corner.centers = {Eigen::Vector3f(-0.3F, 0, 0), {0.3F, 0, 0}, {0, 0, 0}};
  const Weights weights = corner.weights({0.3F, 0.3F, 0.4F});
  EXPECT_NEAR(weights[0], 0.3, 1e-5);
  EXPECT_NEAR(weights[1], 0.3, 1e-5);
  EXPECT_NEAR(weights[2], 0.4, 1e-5);
}

TEST(PositionWeights, AreNeverNegativeAndChangeSteadily) {
  Corner corner;
  Weights before{};
  for (float x = -0.6F; x < 0.6F; x += 0.002F) {  // the third camera passes the two others
    corner.centers[2].x() = x;
    const Weights weights = corner.weights({0.4F, 0.4F, 0.2F});
    float sum = 0;
    for (std::size_t j = 0; j < kCameras; ++j) {
      ASSERT_GE(weights[j], -1e-6F) << "camera " << j << " at " << x;
      if (x > -0.6F) {
        ASSERT_NEAR(weights[j], before[j], 0.02) << "camera " << j << " at " << x;
      }
      sum += weights[j];
    }
    ASSERT_NEAR(sum, 1, 1e-4);
    before = weights;
  }
}

TEST(PositionWeights, OfACameraThatHardlyCountsDecideNothing) {
  Corner corner;
  for (float x = -0.9F; x < 0.9F;
       x += 0.05F) {  // also far beyond the others, where its weight would be negative
    corner.centers[2].x() = x;
    const Weights without = corner.weights({0.6F, 0.4F, 0}), with = corner.weights({0.6F, 0.4F, 1e-5F});
    for (std::size_t j = 0; j < kCameras; ++j)
      ASSERT_NEAR(with[j], without[j], 1e-3) << "camera " << j << " at " << x;
  }
}

TEST(PositionWeights, KnowCamerasAtTheViewAndCamerasThatSeeTheSurfaceFromBehind) {
  Corner corner;
  corner.centers = {Eigen::Vector3f(0, 0, 0), {0, 0, 0}, {0, 0, 0}};
  for (const float weight : corner.weights({0.2F, 0.3F, 0.5F})) EXPECT_GT(weight, 0);
  EXPECT_NEAR(corner.weights({0.2F, 0.3F, 0.5F})[2], 0.5, 1e-6) << "without parallax nothing is moved";
  corner.centers = {Eigen::Vector3f(0.2F, 0.1F, 0), {3, 2, 9}, {-0.1F, 0.3F, 0}};
  for (const float weight : corner.weights({0.4F, 0.2F, 0.4F})) {
    EXPECT_TRUE(std::isfinite(weight));
    EXPECT_GE(weight, 0);
  }
}

// Fields that find the surface `depth` before the proxy read each image beside its pixel, by its parallax
// less what the position weights make of all.
Corner::Places as_fields_say(const Corner::Places& u, const Weights& follow) {
  Eigen::Vector2f mean = Eigen::Vector2f::Zero();
  for (std::size_t j = 0; j < kCameras; ++j) mean += follow[j] * u[j];
  Corner::Places from;
  for (std::size_t j = 0; j < kCameras; ++j) from[j] = u[j] - mean;
  return from;
}

TEST(LeaningOnDepth, LeavesWhatOneDepthExplains) {
  const Corner corner;
  const Weights pull = {0.5F, 0.3F, 0.2F}, follow = corner.weights(pull);
  const Corner::Places from = as_fields_say(corner.parallaxes(0.01F), follow);
  const Corner::Places leaned = corner.leaned(from, follow, pull);
  for (std::size_t j = 0; j < kCameras; ++j) {
    EXPECT_GT(from[j].norm(), 0.3F) << "nothing is tested";
    EXPECT_LT((leaned[j] - from[j]).norm(), 0.05F * from[j].norm()) << "camera " << j;
  }
}

TEST(LeaningOnDepth, TakesBackHalfOfWhatNoDepthExplains) {
  const Corner corner;
  const Weights pull = {0.5F, 0.3F, 0.2F};
  const Corner::Places u = corner.parallaxes(0.01F);
  Corner::Places across;  // what a flow made up, across all parallaxes
  for (std::size_t j = 0; j < kCameras; ++j) across[j] = Eigen::Vector2f(-u[j].y(), u[j].x());
  const Corner::Places leaned = corner.leaned(across, {0, 0, 0}, pull);
  for (std::size_t j = 0; j < kCameras; ++j)
    EXPECT_LT((leaned[j] - 0.5F * across[j]).norm(), 0.02F * across[j].norm()) << "camera " << j;
}

TEST(LeaningOnDepth, BringsImagesNearerToWhereTheyBelongIfWeightsDoNotCancel) {
  Corner corner;  // on a line, so that no weights do
  corner.centers = {Eigen::Vector3f(-0.5F, 0.3F, 0), {0.1F, 0.3F, 0}, {0.5F, 0.3F, 0}};
  const Weights pull = {0.4F, 0.3F, 0.3F}, follow = corner.weights(pull);
  const Corner::Places u = corner.parallaxes(0.01F), from = as_fields_say(u, follow),
                       leaned = corner.leaned(from, follow, pull);
  for (std::size_t j = 0; j < kCameras; ++j) {
    EXPECT_GT((from[j] - u[j]).norm(), 0.2F) << "nothing is tested";
    EXPECT_LT((leaned[j] - u[j]).norm(), 0.6F * (from[j] - u[j]).norm()) << "camera " << j;
  }
}

TEST(LeaningOnDepth, ListensToNobodyWhoHardlyCounts) {
  const Corner corner;
  const Weights follow = corner.weights({0.6F, 0.4F, 0});
  Corner::Places from = as_fields_say(corner.parallaxes(0.01F), follow);
  const Corner::Places without = corner.leaned(from, follow, {0.6F, 0.4F, 0});
  from[2] = {40, -30};
  const Corner::Places with = corner.leaned(from, follow, {0.6F, 0.4F, 5e-4F});
  for (std::size_t j = 0; j < 2; ++j) EXPECT_LT((with[j] - without[j]).norm(), 1e-3F) << "camera " << j;
}

TEST(LeaningOnDepth, MovesNothingWhereNothingMovesAndNoCameraHasParallax) {
  Corner corner;
  const Weights pull = {0.5F, 0.3F, 0.2F};
  const Eigen::Vector2f still(0, 0);
  for (const Eigen::Vector2f& place : corner.leaned({still, still, still}, corner.weights(pull), pull))
    EXPECT_EQ(place.norm(), 0);
  corner.centers = {Eigen::Vector3f::Zero(), Eigen::Vector3f::Zero(), Eigen::Vector3f::Zero()};
  const Eigen::Vector2f moved(3, -1);
  for (const Eigen::Vector2f& place : corner.leaned({moved, moved, moved}, pull, pull))
    EXPECT_LT((place - 0.5F * moved).norm(), 1e-4F);
}

class FloatingPositions : public OnEachBackEnd {};
FLOATSTAGE_ON_EACH_BACK_END(FloatingPositions);

constexpr int kBackdrop = 40;

// A soft bright square about the world's origin, photographed from `places` (degrees around and above), on a
// proxy that stands `behind` metres behind it.
Stage square_before_a_wall(const std::vector<Eigen::Vector2d>& places, float behind) {
  constexpr float kHalf = 0.3F;
  Stage stage;
  for (std::size_t c = 0; c < places.size(); ++c) {
    RigCamera& camera = stage.rig.cameras.emplace_back();
    camera.serial = text("cam", c);
    camera.model = small_camera(200, 160);
    camera.cam_from_world = on_orbit(places[c].x(), places[c].y());
    const Eigen::Vector2d center = *project(camera.model, camera.cam_from_world * Eigen::Vector3d::Zero());
    Image photo(camera.model.width, camera.model.height, 3, kBackdrop);
    for (int y = 0; y < photo.height; ++y)
      for (int x = 0; x < photo.width; ++x) {
        const double away = std::max(std::abs(x + 0.5 - center.x()), std::abs(y + 0.5 - center.y()));
        std::fill_n(photo.at(x, y), 3,
                    static_cast<std::uint8_t>(kBackdrop + 180 * std::clamp((16 - away) / 4, 0.0, 1.0)));
      }
    FrameInfo info;
    info.camera = static_cast<int>(c);
    stage.scene.images.frames.push_back(make_frame(info, photo));
    stage.scene.mattes.emplace_back();
  }
  stage.scene.mesh.positions = {
      {-behind, -kHalf, -kHalf}, {-behind, kHalf, -kHalf}, {-behind, kHalf, kHalf}, {-behind, -kHalf, kHalf}};
  stage.scene.mesh.triangles = {0, 1, 2, 0, 2, 3};
  return stage;
}

Eigen::Vector2d center_of_light(const Image& picture) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x)
      if (picture.at(x, y)[3] > 0)
        sum += std::max(0, picture.at(x, y)[1] - kBackdrop - 8) * Eigen::Vector3d(x + 0.5, y + 0.5, 1);
  return sum.head<2>() / sum.z();
}

TEST_P(FloatingPositions, WhatStandsBeforeTheProxyIsDrawnWhereItIs) {
  const View view = view_at(8, 12, small_camera(200, 160));
  const Eigen::Vector2d truth = *project(view.model, view.view_from_world * Eigen::Vector3d::Zero());
  const auto away = [&](const std::vector<Eigen::Vector2d>& places, Positions positions) {
    RendererOptions options;
    options.positions = positions;
    return (center_of_light(rendered(square_before_a_wall(places, 0.05F), view, "floating", options)) - truth)
        .norm();
  };
  // Two cameras, three on a line, three around the view: in the mean the further camera pulls.
  EXPECT_LT(away({{0, 12}, {12, 12}}, Positions::Parallax), 0.25);
  EXPECT_LT(away({{0, 12}, {12, 12}, {34, 12}}, Positions::Parallax), 0.3);
  EXPECT_GT(away({{0, 12}, {12, 12}, {34, 12}}, Positions::Mean), 0.6);
  EXPECT_LT(away({{0, 11}, {14, 11}, {9, 45}}, Positions::Parallax), 0.3);
  EXPECT_GT(away({{0, 11}, {14, 11}, {9, 45}}, Positions::Mean), 0.5);
}

TEST_P(FloatingPositions, ABallThatIsTooLargeIsDrawnNearerToTheTruth) {
  const Stage stage = photographed(arc(5, 20), ball(0.25F, 48), ball(0.265F, 24));
  for (const double degrees : {4., 8., 15.}) {
    const View view = view_at(degrees);
    const Photograph truth =
        photograph(ball(0.25F, 48), view.model, view.view_from_world, 3, random_checker(0.04F, 5));
    const auto score = [&](Positions positions) {
      RendererOptions options;
      options.positions = positions;
      const Image picture = rendered(stage, view, "floating", options);
      return psnr(picture, truth.rgb,
                  [&](int x, int y) { return *truth.alpha.at(x, y) == 255 && picture.at(x, y)[3] > 0; });
    };
    const double parallax = score(Positions::Parallax), mean = score(Positions::Mean);
    EXPECT_GT(parallax, mean + 1) << degrees;
  }
}

TEST_P(FloatingPositions, HaveRoomForEightPhotographsOfAWholePicture) {
  const Rig rig = arc(8, 4, small_camera(96, 72));
  const Stage stage = photographed(rig, ball(0.9F, 24), ball(0.9F, 24), false);
  RendererOptions options;
  options.cameras = 8;
  View view = view_at(0, 10, small_camera(96, 72));
  view.view_from_world = on_orbit(0, 10, 1.2);
  const Image picture = rendered(stage, view, "floating", options);
  for (int x = 0; x < picture.width; ++x) ASSERT_EQ(picture.at(x, 36)[3], 255) << "the row is not covered";
}

}  // namespace
}  // namespace floatstage::render
