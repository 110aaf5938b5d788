// How much of a photograph a pixel covers, and that pictures smaller than the photographs are means of them.
#include "render/footprint.h"

#include <random>

#include "render/cpu/footprint_kernels.h"
#include "render/photo_pyramid.h"
#include "tests/render/stage.h"

namespace floatstage::render {
namespace {

double random_in(std::mt19937& numbers, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(numbers);
}

// A patch of surface seen by a view and by a camera: the middle pixel's footprint by finite differences.
struct Patch {
  View view;
  RigCamera camera;
  Eigen::Vector3d place = Eigen::Vector3d::Zero(), normal;

  explicit Patch(std::mt19937& numbers) {
    auto around = [&](double from, double to) {
      return on_orbit(random_in(numbers, -40, 40), random_in(numbers, -30, 30), random_in(numbers, from, to));
    };
    view.model = small_camera();
    view.model.fx *= random_in(numbers, 0.3, 1);
    view.model.fy = 1.1 * view.model.fx;
    view.model.skew = random_in(numbers, -5, 5);
    view.view_from_world = around(0.8, 2);
    camera.model = small_camera();
    camera.cam_from_world = around(0.6, 1);
    normal = Eigen::Vector3d(1, random_in(numbers, -0.5, 0.5), random_in(numbers, -0.5, 0.5)).normalized();
  }
  Eigen::Vector2d photographed(const Eigen::Vector2d& pixel) const {
    const Eigen::Vector3d eye = view.view_from_world.center();
    const Eigen::Vector3d way = view.view_from_world.rotation.conjugate() * *unproject(view.model, pixel);
    const Eigen::Vector3d at = eye + way * (normal.dot(place - eye) / normal.dot(way));
    return *project(camera.model, camera.cam_from_world * at);
  }
  Eigen::Vector2d pixel() const { return *project(view.model, view.view_from_world * place); }
  double area_by_differences() const {
    constexpr double kStep = 1e-3;
    Eigen::Matrix2d j;
    for (int axis = 0; axis < 2; ++axis) {
      const Eigen::Vector2d step = kStep * Eigen::Vector2d::Unit(axis);
      j.col(axis) = (photographed(pixel() + step) - photographed(pixel() - step)) / (2 * kStep);
    }
    const double shorter = Eigen::JacobiSVD<Eigen::Matrix2d>(j).singularValues()[1];
    return shorter * shorter;
  }
};

cpu::ViewRays rays_of(const View& view) {
  cpu::ViewRays rays{};
  rays.inverse_fx = static_cast<float>(1 / view.model.fx);
  rays.inverse_fy = static_cast<float>(1 / view.model.fy);
  rays.cx = static_cast<float>(view.model.cx);
  rays.cy = static_cast<float>(view.model.cy);
  rays.skew = static_cast<float>(view.model.skew);
  const Eigen::Matrix4d to_world = view.view_from_world.inverse().matrix();
  for (int i = 0; i < 9; ++i)
    rays.world_from_view[static_cast<std::size_t>(i)] = static_cast<float>(to_world(i / 3, i % 3));
  for (int i = 0; i < 3; ++i)
    rays.eye[static_cast<std::size_t>(i)] = static_cast<float>(view.view_from_world.center()[i]);
  return rays;
}

float footprint_of(const Patch& patch) {
  constexpr std::size_t kPadded = 16;
  const Eigen::Vector2d pixel = patch.pixel();
  const double z = (patch.view.view_from_world * patch.place).z();
  std::array<float, kPadded> x{}, inverse_z{}, nx{}, ny{}, nz{}, area{};
  x.fill(static_cast<float>(pixel.x()));
  inverse_z.fill(static_cast<float>(1 / z));
  nx.fill(static_cast<float>(patch.normal.x()));
  ny.fill(static_cast<float>(patch.normal.y()));
  nz.fill(static_cast<float>(patch.normal.z()));
  SceneTile tile;
  tile.resize(patch.camera.model.width, patch.camera.model.height);
  const cpu::PhotoCamera camera = cpu::photo_camera(camera_block(patch.camera, 0), tile);
  cpu::footprints(camera, rays_of(patch.view),
                  {x.data(), nullptr, inverse_z.data(), static_cast<float>(pixel.y()), 1},
                  {nx.data(), ny.data(), nz.data()}, area.data());
  return area[0];
}

TEST(Footprint, IsTheDerivativeOfTheProjectionAlongTheSurface) {
  std::mt19937 numbers(7);
  for (int i = 0; i < 200; ++i) {
    const Patch patch(numbers);
    const double expected = patch.area_by_differences();
    EXPECT_NEAR(footprint_of(patch), expected, 1e-3 * expected) << i;
  }
}

TEST(Footprint, NeverExceedsTheBoundThatLeavesPyramidsAlone) {
  std::mt19937 numbers(8);
  int left_alone = 0;
  for (int i = 0; i < 2000; ++i) {
    const Patch patch(numbers);
    const Eigen::AlignedBox3f box(Eigen::Vector3f::Constant(-1e-3F), Eigen::Vector3f::Constant(1e-3F));
    if (deepest_level(patch.camera, patch.view, box) > 0) continue;
    ++left_alone;
    EXPECT_LE(patch.area_by_differences(), static_cast<double>(kSharpArea)) << i;
  }
  EXPECT_GT(left_alone, 40) << "a bound that is always passed says nothing";
}

TEST(Footprint, IsWithinTheBoundWherePicturesAreAsLargeAsPhotographs) {
  const Rig rig = arc(3, 20);
  const Eigen::AlignedBox3f box(Eigen::Vector3f::Constant(-0.05F), Eigen::Vector3f::Constant(0.05F));
  EXPECT_EQ(deepest_level(rig.cameras[0], view_at(5), box), 0);
  EXPECT_EQ(deepest_level(rig.cameras[0], view_at(5, 10, small_camera(80, 60)), box), 1);
  View behind = view_at(5);
  behind.view_from_world = on_orbit(5, 10, 0.5);
  EXPECT_EQ(deepest_level(rig.cameras[0], behind, box), 0) << "a close-up covers less than a pixel";
}

TEST(LevelMix, HasTheVarianceOfASquareALittleSmallerThanTheFootprint) {
  for (const float area : {2.F, 4.F, 5.F, 9.F, 16.F, 40.F, 300.F}) {
    const LevelMix mix = level_mix(area);
    // A square of side s has the variance s²/12; a mix of filters has the mix of their variances.
    const float here = std::ldexp(1.F, 2 * mix.level);
    EXPECT_NEAR((1 - mix.next) * here + mix.next * 4 * here, area / kSharpArea, 1e-4F * area) << area;
  }
}

TEST(LevelMix, ReadsThePhotographUpToItsOwnSizeAndChangesSteadily) {
  EXPECT_EQ(level_mix(1).level, 0);
  EXPECT_EQ(level_mix(kSharpArea).next, 0);
  EXPECT_EQ(level_mix(std::numeric_limits<float>::quiet_NaN()).level, 0);
  EXPECT_EQ(level_mix(1e9F).level, kLastLevel);
  EXPECT_EQ(level_mix(1e9F).next, 0);
  for (int level = 0; level <= kLastLevel; ++level) {
    EXPECT_EQ(level_mix(area_of_level(level)).level, level);
    EXPECT_EQ(level_mix(area_of_level(level)).next, 0) << "level " << level << " alone";
  }
  float before = 0;
  for (float side = 1; side < 40; side *= 1.001F) {
    const LevelMix mix = level_mix(side * side);
    const float depth = static_cast<float>(mix.level) + mix.next;
    EXPECT_GE(depth, before - 1e-6F) << side;
    EXPECT_LT(depth, before + 0.01F) << side;
    before = depth;
  }
}

class SmallPictures : public OnEachBackEnd {};
FLOATSTAGE_ON_EACH_BACK_END(SmallPictures);

Image averaged(const Image& rgb, int n) {
  Image small(rgb.width / n, rgb.height / n, rgb.channels);
  for (int y = 0; y < small.height; ++y)
    for (int x = 0; x < small.width; ++x)
      for (int c = 0; c < small.channels; ++c) {
        int sum = 0;
        for (int k = 0; k < n * n; ++k) sum += rgb.at(n * x + k % n, n * y + k / n)[c];
        small.at(x, y)[c] = static_cast<std::uint8_t>((sum + n * n / 2) / (n * n));
      }
  return small;
}

TEST_P(SmallPictures, AtACameraAreNearItsPhotographAveraged) {
  const Stage stage = photographed(arc(3, 20), ball(0.25F), ball(0.25F));
  const Image photograph = *to_rgb(stage.scene.images.frames[1]);
  for (const int n : {2, 4}) {
    View view = view_of(stage.rig.cameras[1]);
    view.model = small_camera(160 / n, 120 / n);
    const Image truth = averaged(photograph, n);
    for (const char* method : {"nearest", "linear", "filtered", "floating", "floating-static"}) {
      const Image picture = rendered(stage, view, method);
      EXPECT_GT(psnr(picture, truth, [&](int x, int y) { return well_inside(picture, x, y, 2); }), 29)
          << method << " at 1/" << n;
    }
  }
}

TEST_P(SmallPictures, BetweenCamerasAreNearTheTruth) {
  const Stage stage = photographed(arc(3, 20), ball(0.25F), ball(0.25F));
  const View view = view_at(4, 10, small_camera(40, 30));
  const Photograph truth =
      photograph(ball(0.25F), view.model, view.view_from_world, 12, random_checker(0.04F, 5));
  for (const char* method : {"nearest", "linear", "floating"}) {
    const Image picture = rendered(stage, view, method);
    EXPECT_GT(psnr(picture, truth.rgb, [&](int x, int y) { return well_inside(picture, x, y, 2); }), 32)
        << method;
  }
}

}  // namespace
}  // namespace floatstage::render
