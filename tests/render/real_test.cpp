// The Stanford bunny of the thesis' Figure 61: a solid checker, a coarse proxy of 948 triangles, 7x7
// photographs.

#include <cstdlib>
#include <filesystem>
#include <numbers>

#include "core/mesh_io.h"
#include "core/parallel.h"
#include "tests/render/stage.h"
#include "tests/support/real_data.h"

namespace floatstage::render {
namespace {

constexpr int kGrid = 7;
constexpr double kStepDegrees = 10, kMiddleElevation = 15;
constexpr int kErosion = 2;  // px

RigCamera bunny_camera(double azimuth, double elevation) {
  constexpr double kRadian = std::numbers::pi / 180;
  const double a = azimuth * kRadian, e = elevation * kRadian;
  const Eigen::Vector3d target(-0.017, 0.11, 0);  // the bunny's world is y up
  RigCamera camera;
  camera.model.width = camera.model.height = 512;
  camera.model.fx = camera.model.fy = 1150;
  camera.model.cx = camera.model.cy = 256;
  camera.cam_from_world = look_at(
      target + 0.45 * Eigen::Vector3d(std::sin(a) * std::cos(e), std::sin(e), std::cos(a) * std::cos(e)),
      target, Eigen::Vector3d::UnitY());
  return camera;
}

/// Test views between the grid's nodes.
std::vector<RigCamera> test_views() {
  std::vector<RigCamera> views;
  for (const auto& [azimuth, elevation] : {std::pair(-25, -8), std::pair(-15, 2), std::pair(-5, 12),
                                           std::pair(5, 22), std::pair(15, 32), std::pair(25, 42)})
    views.push_back(bunny_camera(azimuth, elevation));
  return views;
}

class Bunny : public OnEachBackEnd {
 protected:
  void SetUp() override {
    const std::filesystem::path folder = real_data("stanford-bunny");
    FLOATSTAGE_NEEDS_DATA(folder);
    OnEachBackEnd::SetUp();
    const Result<Mesh> full = load_ply(folder / "bun_zipper.ply"),
                       coarse = load_ply(folder / "bun_zipper_res4.ply");
    ASSERT_THAT(full, IsOk());
    ASSERT_THAT(coarse, IsOk());
    exact_ = *full;
    coarse_ = *coarse;
    views_ = test_views();
    for (int row = 0; row < kGrid; ++row)
      for (int column = 0; column < kGrid; ++column) {
        RigCamera camera = bunny_camera(kStepDegrees * (column - kGrid / 2),
                                        kMiddleElevation + kStepDegrees * (row - kGrid / 2));
        camera.serial = text(row, "-", column);
        stage_.rig.cameras.push_back(camera);
      }
    const std::size_t count = stage_.rig.cameras.size();
    std::vector<Photograph> photographs(count + views_.size());
    parallel_for(photographs.size(), 0, [&](std::size_t i) {
      const RigCamera& camera = i < count ? stage_.rig.cameras[i] : views_[i - count];
      photographs[i] = photograph(exact_, camera.model, camera.cam_from_world, 3, random_checker(0.006F, 7));
    });
    for (std::size_t i = 0; i < count; ++i) {
      stage_.scene.images.frames.push_back(make_frame({}, photographs[i].rgb));
      stage_.scene.mattes.push_back(make_matte({}, photographs[i].alpha));
    }
    truth_.assign(photographs.begin() + static_cast<std::ptrdiff_t>(count), photographs.end());
  }

  /// Mean PSNR over the test views, in the eroded intersection of the true silhouette and the proxy.
  double score(const Mesh& proxy, const char* method) {
    stage_.scene.mesh = proxy;
    render::Scene scene;
    EXPECT_THAT(scene.set(stage_.rig, stage_.scene), IsOk());
    const auto renderer = make(method);
    double sum = 0;
    for (std::size_t i = 0; i < views_.size(); ++i) {
      const auto rendering = renderer->render(scene, view_of(views_[i]), {});
      EXPECT_THAT(rendering, IsOk());
      const Image picture = download(*rendering);
      sum += psnr(picture, truth_[i].rgb, [&](int x, int y) {
        for (int v = -kErosion; v <= kErosion; ++v)
          for (int u = -kErosion; u <= kErosion; ++u) {
            if (u * u + v * v > kErosion * kErosion + 1) continue;
            if (x + u < 0 || y + v < 0 || x + u >= 512 || y + v >= 512) return false;
            if (picture.at(x + u, y + v)[3] == 0 || *truth_[i].alpha.at(x + u, y + v) < 128) return false;
          }
        return true;
      });
    }
    return sum / static_cast<double>(views_.size());
  }

  Mesh exact_, coarse_;
  Stage stage_;
  std::vector<RigCamera> views_;
  std::vector<Photograph> truth_;
};
FLOATSTAGE_ON_EACH_BACK_END(Bunny);

TEST_P(Bunny, FloatingBeatsLinearOnTheCoarseProxyAndLosesNothingOnTheExactOne) {
  const double nearest = score(coarse_, "nearest"), linear = score(coarse_, "linear"),
               floating = score(coarse_, "floating");
  EXPECT_GT(linear, nearest + 1);
  EXPECT_GT(floating, linear + 0.5);
  EXPECT_GT(floating, 25.5);
  const double exact_linear = score(exact_, "linear"), exact_floating = score(exact_, "floating");
  EXPECT_GT(exact_linear, 30);
  EXPECT_GT(exact_floating, exact_linear - 0.1);
  RecordProperty("psnr", text("948 triangles: nearest ", nearest, " linear ", linear, " floating ", floating,
                              "; exact: linear ", exact_linear, " floating ", exact_floating));
}

}  // namespace
}  // namespace floatstage::render
