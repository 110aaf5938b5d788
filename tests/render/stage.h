#pragma once

#include <cmath>

#include <gtest/gtest.h>

#include "core/synthetic/mesh_photograph.h"
#include "render/gl_context.h"
#include "render/renderer.h"
#include "tests/support/matchers.h"

namespace floatstage::render {

/// A small stage with truth: a checkered ball photographed by cameras on an arc.
struct Stage {
  Rig rig;
  SceneFrame scene;
};

inline CameraModel small_camera(int width = 160, int height = 120) {
  CameraModel m;
  m.width = width;
  m.height = height;
  m.fx = m.fy = 1.5 * width;
  m.cx = 0.5 * width;
  m.cy = 0.5 * height;
  return m;
}

/// Looks at the origin from `degrees` around the z axis and `elevation` above the floor plane.
inline Rigid3 on_orbit(double degrees, double elevation = 10, double distance = 1) {
  const double a = degrees * M_PI / 180, e = elevation * M_PI / 180;
  return look_at(
      distance * Eigen::Vector3d(std::cos(a) * std::cos(e), std::sin(a) * std::cos(e), std::sin(e)),
      Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ());
}

/// A ball of latitude and longitude quads; `flatten` squeezes it along z.
inline Mesh ball(float radius, int rings = 24, float flatten = 1) {
  Mesh mesh;
  const int around = 2 * rings;
  for (int r = 0; r <= rings; ++r)
    for (int a = 0; a < around; ++a) {
      const double theta = M_PI * r / rings, phi = 2 * M_PI * a / around;
      mesh.positions.push_back(radius * Eigen::Vector3d(std::sin(theta) * std::cos(phi),
                                                        std::sin(theta) * std::sin(phi),
                                                        flatten * std::cos(theta))
                                            .cast<float>());
    }
  for (int r = 0; r < rings; ++r)
    for (int a = 0; a < around; ++a) {
      const auto at = [&](int row, int column) {
        return static_cast<std::uint32_t>(row * around + column % around);
      };
      const std::uint32_t nw = at(r, a), ne = at(r, a + 1), sw = at(r + 1, a), se = at(r + 1, a + 1);
      if (r > 0) mesh.triangles.insert(mesh.triangles.end(), {nw, sw, ne});
      if (r + 1 < rings) mesh.triangles.insert(mesh.triangles.end(), {ne, sw, se});
    }
  return mesh;
}

/// `true_mesh` photographed by `rig`, textured with a solid checker of 4 cm cells, and `proxy` to render it
/// with.
inline Stage photographed(Rig rig, const Mesh& true_mesh, const Mesh& proxy, bool mattes = true) {
  Stage stage{std::move(rig), {}};
  for (std::size_t i = 0; i < stage.rig.cameras.size(); ++i) {
    const RigCamera& camera = stage.rig.cameras[i];
    const Photograph p =
        photograph(true_mesh, camera.model, camera.cam_from_world, 3, random_checker(0.04F, 5));
    FrameInfo info;
    info.camera = static_cast<int>(i);
    stage.scene.images.frames.push_back(make_frame(info, p.rgb));
    stage.scene.mattes.push_back(mattes ? make_matte(info, p.alpha) : Matte{});
  }
  stage.scene.mesh = proxy;
  return stage;
}

inline Rig arc(int count, double step_degrees, const CameraModel& model = small_camera()) {
  Rig rig;
  for (int i = 0; i < count; ++i) {
    RigCamera camera;
    camera.serial = text("cam", i);
    camera.model = model;
    camera.cam_from_world = on_orbit(step_degrees * (i - 0.5 * (count - 1)));
    rig.cameras.push_back(camera);
  }
  return rig;
}

inline View view_of(const RigCamera& camera) {
  View view;
  view.model = pinhole(camera.model);
  view.view_from_world = camera.cam_from_world;
  return view;
}

inline View view_at(double degrees, double elevation = 10, const CameraModel& model = small_camera()) {
  View view;
  view.model = model;
  view.view_from_world = on_orbit(degrees, elevation);
  return view;
}

/// Pixels where `keep` holds, PSNR of the RGB of a 4-channel picture against a 3- or 4-channel one.
template <class Keep>
double psnr(const Image& picture, const Image& truth, Keep keep) {
  double sum = 0;
  std::size_t count = 0;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      if (!keep(x, y)) continue;
      ++count;
      for (int c = 0; c < 3; ++c) {
        const double d = static_cast<double>(picture.at(x, y)[c]) - truth.at(x, y)[c];
        sum += d * d;
      }
    }
  EXPECT_GT(count, 0U) << "nothing to compare";
  return 10 * std::log10(255.0 * 255.0 / std::max(sum / (3.0 * static_cast<double>(count)), 1e-9));
}

/// Every pixel within `radius` of (x, y) is covered by the proxy.
inline bool well_inside(const Image& picture, int x, int y, int radius) {
  for (int v = y - radius; v <= y + radius; ++v)
    for (int u = x - radius; u <= x + radius; ++u)
      if (u < 0 || v < 0 || u >= picture.width || v >= picture.height || picture.at(u, v)[3] == 0)
        return false;
  return true;
}

/// What a test that draws needs: a back-end.
class Rendering : public testing::Test {
 protected:
  void open(render::BackEnd back_end) {
    if (back_end == render::BackEnd::Gl) {
      Result<std::unique_ptr<GlContext>> made = GlContext::headless();
      ASSERT_THAT(made, IsOk());
      context_ = std::move(*made);
    }
    back_end_ = back_end;
  }
  std::unique_ptr<ViewRenderer> make(std::string_view method) const {
    Result<std::unique_ptr<ViewRenderer>> renderer = make_renderer(method, back_end_);
    EXPECT_THAT(renderer, IsOk());
    return renderer ? std::move(*renderer) : nullptr;
  }
  /// Renders one picture from scratch.
  Image rendered(const Stage& stage, const View& view, std::string_view method,
                 const RendererOptions& options = {}, const std::vector<bool>& usable = {}) const {
    render::Scene scene;
    const Result<void> set = scene.set(stage.rig, stage.scene, usable);
    EXPECT_THAT(set, IsOk());
    const std::unique_ptr<ViewRenderer> renderer = make(method);
    if (!set || !renderer) return {};
    const Result<RenderedView> picture = renderer->render(scene, view, options);
    EXPECT_THAT(picture, IsOk());
    return picture ? download(*picture) : Image{};
  }

 private:
  std::unique_ptr<GlContext> context_;
  render::BackEnd back_end_ = render::BackEnd::Cpu;
};

inline std::string name_of(render::BackEnd back_end) {
  return render::back_end_names()[static_cast<std::size_t>(back_end)];
}

/// A test that must pass on every back-end.
class OnEachBackEnd : public Rendering, public testing::WithParamInterface<render::BackEnd> {
 protected:
  void SetUp() override { open(GetParam()); }
};

// Runs the tests of a fixture on every back-end.
#define FLOATSTAGE_ON_EACH_BACK_END(fixture)                                                        \
  INSTANTIATE_TEST_SUITE_P(On, fixture, testing::Values(render::BackEnd::Cpu, render::BackEnd::Gl), \
                           [](const auto& param) { return name_of(param.param); })

}  // namespace floatstage::render
