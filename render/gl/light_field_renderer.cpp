#include "render/gl/light_field_renderer.h"

#include <algorithm>

#include "render/footprint.h"
#include "render/gl/blending_pass.h"
#include "render/gl/inspection.h"
#include "render/gl/projection.h"
#include "render/light_field.h"
#include "render/stage_times.h"

namespace floatstage::render {
namespace {

class LightFieldRenderer : public ViewRenderer {
 public:
  LightFieldRenderer(Projection projection, Inspection inspection, gl::Kernel blend)
      : projection_(std::move(projection)), inspection_(std::move(inspection)), blend_(std::move(blend)) {}

  Result<RenderedView> render(const Scene& scene, const View& view, const RendererOptions& options) override {
    if (Result<void> ok = check_render(scene, view, options); !ok) return forward(ok);
    if (Result<void> ok = check_output("light-field", options.output); !ok) return forward(ok);
    const Result<CameraGrid> grid = camera_grid(scene.impl().cameras);
    if (!grid) return forward(grid);
    const Result<const SceneTextures*> textures = SceneTextures::of(scene);
    if (!textures) return forward(textures);
    const LightFieldPlane plane(*grid, view.view_from_world.center());
    projection_.run(**textures, view, options, 0, false, false,
                    1);  // its cameras are others than those listed
    target_.begin(view.model.width, view.model.height);
    if (projection_.window().empty()) {
      target_.clear(options.background);
    } else {
      if (is_shared_intermediate(options.output)) {
        inspection_.draw(projection_, **textures, scene, view, options, target_);
      } else {
        set_plane(plane);
        set_levels(**textures, plane, view);
        StageTimes::enter("blending");
        projection_.draw(blend_, {&projection_.surface()}, target_);
      }
      projection_.soften(**textures, options, target_, false);
    }
    RenderedView drawn = rendered_view(scene, view, projection_, target_);
    drawn.cameras = strongest(scene.impl(), plane, view);
    return drawn;
  }

 private:
  void set_plane(const LightFieldPlane& plane) {
    std::vector<float> places = plane.x;
    places.insert(places.end(), plane.y.begin(), plane.y.end());
    places.insert(places.end(), plane.cameras.begin(), plane.cameras.end());
    gl::upload(places_, capacity_, places.data(), places.size() * sizeof(float));
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, places_.id());
    blend_.set(1, static_cast<int>(plane.x.size()), static_cast<int>(plane.y.size()))
        .set(2, plane.normal)
        .set(3, plane.right)
        .set(4, plane.down)
        .set(5, std::array<float, 3>{plane.height, plane.eye_x, plane.eye_y});
  }

  void set_levels(const SceneTextures& textures, const LightFieldPlane& plane, const View& view) {
    const Scene::Impl& s = *textures.scene;
    int deepest = 0;
    for (int camera : plane.cameras)
      deepest = std::max(deepest, deepest_level(s.cameras[static_cast<std::size_t>(camera)], view, s.box));
    if (deepest > 0) textures.ensure_levels(plane.cameras);
    blend_.set(6, deepest);
  }

  Projection projection_;
  Inspection inspection_;
  gl::Kernel blend_;
  gl::Buffer places_;
  std::size_t capacity_ = 0;
  ViewTarget target_;
};

}  // namespace

Result<std::unique_ptr<ViewRenderer>> make_light_field_renderer() {
  return make_blending_pass<LightFieldRenderer>(
      "light_field.comp", {"view.glsl", "camera.glsl", "footprint.glsl", "false_color.glsl", "picture.glsl"});
}

}  // namespace floatstage::render
