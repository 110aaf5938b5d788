// The Stanford bunny of the thesis' Figure 61: a solid checker, a coarse proxy of 948 triangles, 7x7
// photographs.

#include <cstdlib>
#include <filesystem>

#include "pipeline/reproduce/bunny.h"
#include "tests/render/stage.h"
#include "tests/support/real_data.h"

namespace floatstage::render {
namespace {

constexpr int kGrid = 7;
constexpr double kStepDegrees = 10;
constexpr int kErosion = 2;  // px

/// Test views between the grid's nodes.
std::vector<RigCamera> test_views() {
  std::vector<RigCamera> views;
  for (const auto& [azimuth, elevation] : {std::pair(-25, -8), std::pair(-15, 2), std::pair(-5, 12),
                                           std::pair(5, 22), std::pair(15, 32), std::pair(25, 42)})
    views.push_back(pipeline::bunny_camera(azimuth, elevation));
  return views;
}

class Bunny : public OnEachBackEnd {
 protected:
  void SetUp() override {
    const std::filesystem::path folder = real_data("stanford-bunny");
    FLOATSTAGE_NEEDS_DATA(folder);
    OnEachBackEnd::SetUp();
    const Result<pipeline::Bunny> bunny = pipeline::load_bunny(folder);
    ASSERT_THAT(bunny, IsOk());
    exact_ = bunny->exact;
    coarse_ = bunny->coarse;
    const pipeline::TestScene scene =
        pipeline::painted_bunny(exact_, coarse_, pipeline::bunny_grid(kGrid, kStepDegrees), test_views());
    stage_.rig = scene.rig;
    stage_.scene = scene.photographs;
    views_ = scene.views;
  }

  /// Mean PSNR over the test views, in the eroded intersection of the true silhouette and the proxy.
  double score(const Mesh& proxy, const char* method) {
    stage_.scene.mesh = proxy;
    render::Scene scene;
    EXPECT_THAT(scene.set(stage_.rig, stage_.scene), IsOk());
    const auto renderer = make(method);
    double sum = 0;
    for (std::size_t i = 0; i < views_.size(); ++i) {
      const auto rendering = renderer->render(scene, view_of(views_[i].camera), {});
      EXPECT_THAT(rendering, IsOk());
      const Image picture = download(*rendering);
      sum += psnr(picture, views_[i].rgb, [&](int x, int y) {
        for (int v = -kErosion; v <= kErosion; ++v)
          for (int u = -kErosion; u <= kErosion; ++u) {
            if (u * u + v * v > kErosion * kErosion + 1) continue;
            if (x + u < 0 || y + v < 0 || x + u >= 512 || y + v >= 512) return false;
            if (picture.at(x + u, y + v)[3] == 0 || *views_[i].silhouette.at(x + u, y + v) < 128)
              return false;
          }
        return true;
      });
    }
    return sum / static_cast<double>(views_.size());
  }

  Mesh exact_, coarse_;
  Stage stage_;
  std::vector<pipeline::TrueView> views_;
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
