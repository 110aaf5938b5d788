// The view's opacity at the proxy's outline, against a slow reference.
#include <algorithm>
#include <optional>

#include "render/scene_impl.h"
#include "tests/render/stage.h"

namespace floatstage::render {
namespace {

constexpr double kSamples[4][2] = {{-0.125, -0.375}, {0.375, -0.125}, {-0.375, 0.125}, {0.125, 0.375}};
constexpr double kStandIn = 1e-3, kGrazing = 0.02;

/// A convex proxy as a view sees it: every place of the picture asked of every triangle.
class SlowProxy {
 public:
  SlowProxy(const Mesh& mesh, const View& view) : view_(view) {
    for (std::size_t t = 0; t + 2 < mesh.triangles.size(); t += 3) {
      Face face;
      for (std::size_t k = 0; k < 3; ++k) {
        face.world[k] = mesh.positions[mesh.triangles[t + k]].cast<double>();
        const Eigen::Vector3d p = view.model.k() * (view.view_from_world * face.world[k]);
        face.screen[k] = p.hnormalized();
      }
      faces_.push_back(face);
    }
  }

  struct Hit {
    Eigen::Vector3d world, normal;
  };
  /// The surface that is seen at a place: of a convex body the one that faces the view.
  std::optional<Hit> at(double x, double y) const {
    for (const Face& face : faces_) {
      const Eigen::Vector2d *s = face.screen, here(x, y);
      auto turn = [&](int i) {
        const Eigen::Vector2d a = s[(i + 1) % 3] - s[i], b = here - s[i];
        return a.x() * b.y() - a.y() * b.x();
      };
      if (turn(0) > 0 || turn(1) > 0 || turn(2) > 0) continue;  // seen from outside: clockwise, y down
      const Eigen::Vector3d eye = view_.view_from_world.center();
      const Eigen::Vector3d normal =
          (face.world[1] - face.world[0]).cross(face.world[2] - face.world[0]).normalized();
      const CameraModel& m = view_.model;
      const Eigen::Vector3d ray =
          view_.view_from_world.rotation.inverse() * Eigen::Vector3d((x - m.cx) / m.fx, (y - m.cy) / m.fy, 1);
      const double along = normal.dot(face.world[0] - eye) / normal.dot(ray);
      return Hit{eye + along * ray, normal};
    }
    return std::nullopt;
  }

 private:
  struct Face {
    Eigen::Vector3d world[3];
    Eigen::Vector2d screen[3];
  };
  View view_;
  std::vector<Face> faces_;
};

double matte_at(const Matte& matte, const Eigen::Vector2d& pixel) {
  const Image image = to_image(matte);
  const double x = std::clamp(pixel.x(), 0.5, image.width - 0.5) - 0.5,
               y = std::clamp(pixel.y(), 0.5, image.height - 0.5) - 0.5;
  const int u = std::min(static_cast<int>(x), image.width - 2),
            v = std::min(static_cast<int>(y), image.height - 2);
  auto a = [&](int du, int dv) { return *image.at(u + du, v + dv) / 255.0; };
  const double fx = x - u, fy = y - v;
  return (1 - fy) * ((1 - fx) * a(0, 0) + fx * a(1, 0)) + fy * ((1 - fx) * a(0, 1) + fx * a(1, 1));
}

struct MatteView {
  double mean, most;
  bool watched;  // by a camera that does not look along it
};

/// What the mattes say of a point, by the angles to their cameras.
MatteView mattes_at(const Stage& stage, const CameraChoice& choice, const View& view,
                    const SlowProxy::Hit& hit) {
  double sum = 0, total = 0, most = 0, behind = 0;
  const Eigen::Vector3d to_view = (view.view_from_world.center() - hit.world).normalized();
  for (std::size_t slot = 0; slot < choice.listed.size(); ++slot) {
    const auto i = static_cast<std::size_t>(choice.listed[slot]);
    const RigCamera& camera = stage.rig.cameras[i];
    const Eigen::Vector3d to_camera = (camera.cam_from_world.center() - hit.world).normalized();
    const Eigen::Vector2d pixel = (camera.model.k() * (camera.cam_from_world * hit.world)).hnormalized();
    if (pixel.minCoeff() < 0 || pixel.x() >= camera.model.width || pixel.y() >= camera.model.height) continue;
    const double angle = std::max(std::acos(std::min(to_view.dot(to_camera), 1.0)), 2e-5);
    const double weight = (static_cast<double>(choice.fade[slot]) +
                           kStandIn * static_cast<double>(choice.stand_in_fade[slot])) /
                          angle;
    const double matte = matte_at(stage.scene.mattes[i], pixel);
    behind = std::max(behind, matte);
    if (hit.normal.dot(to_camera) < kGrazing) continue;
    sum += weight * matte;
    total += weight;
    most = std::max(most, matte);
  }
  if (total > 0) return {sum / total, most, true};
  return {1, behind, false};
}

/// The opacity of every pixel, 0 … 1, from the definition (docs/adr/0261-opacity-at-the-outline.md).
std::vector<double> slow_opacity(const Stage& stage, const View& view, const RendererOptions& options) {
  render::Scene scene;
  EXPECT_THAT(scene.set(stage.rig, stage.scene), IsOk());
  const CameraChoice choice = scene.impl().choose(view, options.cameras);
  const SlowProxy proxy(stage.scene.mesh, view);
  const int width = view.model.width, height = view.model.height;
  std::vector<std::optional<SlowProxy::Hit>> hits;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) hits.push_back(proxy.at(x + 0.5, y + 0.5));
  auto index = [&](int x, int y) { return static_cast<std::size_t>(y * width + x); };
  auto inside = [&](int x, int y) { return x >= 0 && y >= 0 && x < width && y < height; };
  std::vector<double> solid(hits.size(), 0), opacity(hits.size(), 0);
  const double radius = options.soft_radius / 2;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const auto& hit = hits[index(x, y)];
      if (!hit) continue;
      double away = 1e9;
      for (int v = 0; v < height; ++v)
        for (int u = 0; u < width; ++u)
          if (!hits[index(u, v)]) away = std::min(away, std::hypot(u - x, v - y));
      const MatteView mattes = mattes_at(stage, choice, view, *hit);
      const double near = std::clamp((radius - away) / (radius - 1), 0.0, 1.0);
      solid[index(x, y)] = std::min(1 - near * (1 - mattes.mean), 2 * mattes.most);
    }
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      double sum = 0, count = 0, others = 0;
      for (int v = y - 1; v <= y + 1; ++v)
        for (int u = x - 1; u <= x + 1; ++u) {
          if (!inside(u, v)) continue;
          if (hits[index(u, v)]) sum += solid[index(u, v)], ++count;
          others += hits[index(u, v)].has_value() != hits[index(x, y)].has_value();
        }
      double covered = 0;
      for (const auto& sample : kSamples)
        covered += others > 0 && proxy.at(x + 0.5 + sample[0], y + 0.5 + sample[1]) ? 0.25 : 0;
      const double share = others == 0 ? 1 : covered;
      opacity[index(x, y)] = hits[index(x, y)] ? solid[index(x, y)] * std::max(share, 0.25)
                             : others > 0      ? covered * sum / count
                                               : 0;
    }
  return opacity;
}

/// A ball with a proxy that is too large for it, small enough for the slow reference.
Stage fat_ball() {
  return photographed(arc(4, 25, small_camera(96, 72)), ball(0.25F, 48, 0.6F), ball(0.262F, 12, 0.6F));
}

class Outlines : public OnEachBackEnd {};
FLOATSTAGE_ON_EACH_BACK_END(Outlines);

TEST_P(Outlines, AreAsOpaqueAsTheSlowReference) {
  const Stage stage = fat_ball();
  const View view = view_at(7, 22, small_camera(80, 60));
  RendererOptions options;
  for (const double radius : {16.0, 8.0}) {
    options.soft_radius = radius;
    const std::vector<double> expected = slow_opacity(stage, view, options);
    const Image picture = rendered(stage, view, "linear", options);
    double partial = 0, wrong = 0, sum = 0, expected_sum = 0;
    for (std::size_t i = 0; i < expected.size(); ++i) {
      const double found = picture.pixels[4 * i + 3] / 255.0;
      partial += expected[i] > 0.02 && expected[i] < 0.98;
      wrong += std::abs(found - expected[i]) > 0.03;  // corners on the raster's grid of 1/256 px, depth maps
      sum += found, expected_sum += expected[i];
    }
    EXPECT_GT(partial, 150) << "radius " << radius;
    EXPECT_LE(wrong, 0.04 * partial) << "radius " << radius;
    EXPECT_NEAR(sum / expected_sum, 1, 2e-3) << "radius " << radius;
  }
}

/// Where some camera sees everything within 3 px of a pixel: what nobody sees takes its colours from around
/// it.
std::vector<bool> seen_around(const Stage& stage, const View& view) {
  render::Scene scene;
  EXPECT_THAT(scene.set(stage.rig, stage.scene), IsOk());
  const CameraChoice choice = scene.impl().choose(view, RendererOptions{}.cameras);
  const SlowProxy proxy(stage.scene.mesh, view);
  const int width = view.model.width, height = view.model.height;
  std::vector<bool> around(static_cast<std::size_t>(width * height), true);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const auto hit = proxy.at(x + 0.5, y + 0.5);
      const MatteView mattes = hit ? mattes_at(stage, choice, view, *hit) : MatteView{1, 1, true};
      if (mattes.watched && mattes.most >= 0.5) continue;
      for (int v = std::max(y - 3, 0); v <= std::min(y + 3, height - 1); ++v)
        for (int u = std::max(x - 3, 0); u <= std::min(x + 3, width - 1); ++u)
          around[static_cast<std::size_t>(v * width + u)] = false;
    }
  return around;
}

TEST_P(Outlines, LeaveColorsAndTheInsideAlone) {
  const Stage stage = fat_ball();
  const View view = view_at(7, 22);
  const std::vector<bool> seen = seen_around(stage, view);
  RendererOptions hard;
  hard.soft_outlines = false;
  for (const char* method : {"nearest", "linear", "filtered", "floating", "floating-static"}) {
    const Image soft = rendered(stage, view, method), opaque = rendered(stage, view, method, hard);
    int beside = 0, compared = 0;
    for (int y = 0; y < opaque.height; ++y)
      for (int x = 0; x < opaque.width; ++x) {
        const std::uint8_t *a = soft.at(x, y), *b = opaque.at(x, y);
        ASSERT_TRUE(b[3] == 0 || b[3] == 255);
        const bool same = b[3] != 0 && seen[static_cast<std::size_t>(y * opaque.width + x)];
        compared += same;
        for (int c = 0; c < 3 && same; ++c) ASSERT_EQ(a[c], b[c]) << method << ' ' << x << ' ' << y;
        if (well_inside(opaque, x, y, 12)) {
          ASSERT_EQ(a[3], 255) << method << ' ' << x << ' ' << y;
        }
        beside += b[3] == 0 && a[3] != 0;
      }
    EXPECT_GT(compared, 2000) << method;
    EXPECT_GT(beside, 10) << method << ": half of the anti-aliasing lies beside the proxy's pixels";
  }
}

TEST_P(Outlines, AreTheMatteWhereACameraStands) {
  const Stage stage = photographed(arc(4, 25), ball(0.25F, 48, 0.6F), ball(0.255F, 48, 0.6F));
  const RigCamera& camera = stage.rig.cameras[1];
  const Image picture = rendered(stage, view_of(camera), "floating"), matte = to_image(stage.scene.mattes[1]);
  double off = 0, hard = 0, count = 0;
  for (int y = 0; y < matte.height; ++y)
    for (int x = 0; x < matte.width; ++x) {
      if (*matte.at(x, y) == 0 || *matte.at(x, y) == 255) continue;
      off += std::abs(picture.at(x, y)[3] - *matte.at(x, y)) / 255.0;
      hard += std::min(*matte.at(x, y) / 255.0, 1 - *matte.at(x, y) / 255.0);
      ++count;
    }
  EXPECT_GT(count, 100);
  EXPECT_LT(off, 0.25 * hard) << "of what any outline without partial pixels must be off";
}

TEST_P(Outlines, HaveNoHolesInside) {
  Stage stage = photographed(arc(3, 25), ball(0.25F, 48), ball(0.25F, 48));
  Image matte = to_image(stage.scene.mattes[1]);  // a keyer took a patch in the middle for the backdrop
  for (int y = 55; y < 65; ++y)
    for (int x = 75; x < 85; ++x) *matte.at(x, y) = 0;
  stage.scene.mattes[1] = make_matte({}, matte);
  RendererOptions hard;
  hard.soft_outlines = false;
  const View view = view_at(3);
  const Image picture = rendered(stage, view, "linear"), opaque = rendered(stage, view, "linear", hard);
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x)
      if (well_inside(opaque, x, y, 12)) {
        ASSERT_EQ(picture.at(x, y)[3], 255) << x << ' ' << y;
      }
}

TEST_P(Outlines, AreShownAsGrey) {
  const Stage stage = fat_ball();
  RendererOptions shown;
  shown.output = RenderOutput::Opacity;
  const View view = view_at(7, 22);
  const Image picture = rendered(stage, view, "linear"), grey = rendered(stage, view, "linear", shown);
  for (std::size_t i = 0; i < picture.pixels.size(); i += 4) {
    ASSERT_EQ(grey.pixels[i], picture.pixels[i + 3]);
    ASSERT_EQ(grey.pixels[i + 3], picture.pixels[i + 3] > 0 ? 255 : 0);
  }
}

TEST(OutlinesOfBothBackEnds, AreAlike) {
  const std::unique_ptr<GlContext> context = std::move(*GlContext::headless());
  const Stage stage = photographed(arc(5, 25), ball(0.25F, 48, 0.6F), ball(0.265F, 16, 0.6F));
  render::Scene scene;
  ASSERT_THAT(scene.set(stage.rig, stage.scene), IsOk());
  RendererOptions options;
  options.flow.backend = "none";
  const View view = view_at(8, 25, small_camera(256, 192));
  for (const char* method : {"linear", "filtered", "floating", "floating-static"}) {
    Image pictures[2];
    for (int i = 0; i < 2; ++i) {
      const auto renderer =
          std::move(*make_renderer(method, i == 0 ? render::BackEnd::Cpu : render::BackEnd::Gl));
      const Result<RenderedView> picture = renderer->render(scene, view, options);
      ASSERT_THAT(picture, IsOk());
      pictures[i] = download(*picture);
    }
    double squares = 0, rim = 0;
    for (std::size_t i = 3; i < pictures[0].pixels.size(); i += 4) {
      squares += std::pow(pictures[0].pixels[i] - pictures[1].pixels[i], 2);
      rim += pictures[0].pixels[i] != 0 && pictures[0].pixels[i] != 255;
    }
    EXPECT_GT(rim, 500) << method;
    // Of the partial pixels alone; over the whole picture it is 15 dB more.
    EXPECT_GT(10 * std::log10(255.0 * 255 * rim / std::max(squares, 1e-9)), 35) << method;
  }
}

}  // namespace
}  // namespace floatstage::render
