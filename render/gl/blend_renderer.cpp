#include "render/gl/blend_renderer.h"

#include "render/gl/blending_pass.h"
#include "render/gl/inspection.h"
#include "render/gl/projection.h"
#include "render/stage_times.h"

namespace floatstage::render {
namespace {

class BlendRenderer : public ViewRenderer {
 public:
  BlendRenderer(bool one_camera, Projection projection, Inspection inspection, gl::Kernel blend)
      : one_camera_(one_camera),
        projection_(std::move(projection)),
        inspection_(std::move(inspection)),
        blend_(std::move(blend)) {}

  Result<RenderedView> render(const Scene& scene, const View& view, const RendererOptions& options) override {
    if (Result<void> ok = check_render(scene, view, options); !ok) return forward(ok);
    const Result<const SceneTextures*> textures = SceneTextures::of(scene);
    if (!textures) return forward(textures);
    if (Result<void> ok = check_output(one_camera_ ? "nearest" : "linear", options.output); !ok)
      return forward(ok);
    projection_.run(**textures, view, options, 0, one_camera_);
    target_.begin(view.model.width, view.model.height);
    if (projection_.window().empty()) {
      target_.clear(options.background);
    } else {
      if (is_shared_intermediate(options.output)) {
        inspection_.draw(projection_, **textures, scene, view, options, target_);
      } else {
        StageTimes::enter("blending");
        projection_.draw(blend_, {&projection_.surface(), &projection_.weights(0), &projection_.weights(1)},
                         target_);
      }
      projection_.soften(**textures, options, target_);
    }
    return rendered_view(scene, view, projection_, target_);
  }

 private:
  bool one_camera_;
  Projection projection_;
  Inspection inspection_;
  gl::Kernel blend_;
  ViewTarget target_;
};

}  // namespace

Result<std::unique_ptr<ViewRenderer>> make_blend_renderer(bool one_camera) {
  return make_blending_pass<BlendRenderer>(
      "blend.comp", {"view.glsl", "camera.glsl", "footprint.glsl", "false_color.glsl", "picture.glsl"},
      one_camera);
}

}  // namespace floatstage::render
