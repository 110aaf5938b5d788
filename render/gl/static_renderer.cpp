#include "render/gl/static_renderer.h"

#include <array>
#include <vector>

#include "render/cpu/field_maker.h"
#include "render/gl/blending_pass.h"
#include "render/gl/field_textures.h"
#include "render/gl/inspection.h"
#include "render/gl/projection.h"
#include "render/stage_times.h"

namespace floatstage::render {
namespace {

// shaders/static.comp has the twin.
struct GridBlock {
  std::array<std::array<float, 4>, kMostListed> place, size;
  std::array<int, static_cast<std::size_t>(kMostListed) * kMostListed> layer;
};

class StaticRenderer : public ViewRenderer {
 public:
  StaticRenderer(Projection projection, Inspection inspection, gl::Kernel blend)
      : projection_(std::move(projection)), inspection_(std::move(inspection)), blend_(std::move(blend)) {}

  Result<RenderedView> render(const Scene& scene, const View& view, const RendererOptions& options) override {
    if (Result<void> ok = check_render(scene, view, options); !ok) return forward(ok);
    if (Result<void> ok = check_output("floating-static", options.output); !ok) return forward(ok);
    const Result<const SceneTextures*> textures = SceneTextures::of(scene);
    if (!textures) return forward(textures);
    projection_.run(**textures, view, options, 0, false);
    target_.begin(view.model.width, view.model.height);
    if (projection_.window().empty()) {
      target_.clear(options.background);
    } else {
      if (is_shared_intermediate(options.output)) {
        inspection_.draw(projection_, **textures, scene, view, options, target_);
      } else {
        if (Result<void> ok = find_fields(scene, options); !ok) return forward(ok);
        StageTimes::enter("blending");
        blend_.set(1, static_cast<int>(options.positions));
        projection_.draw(blend_,
                         {&projection_.surface(), &projection_.weights(0), &projection_.weights(1),
                          &projection_.angular(0), &projection_.angular(1), &fields_.texture()},
                         target_);
      }
      projection_.soften(**textures, options, target_);
    }
    return rendered_view(scene, view, projection_, target_);
  }

 private:
  // Fields are estimated in native code, whoever draws with them: they are the same then.
  Result<void> find_fields(const Scene& scene, const RendererOptions& options) {
    Result<cpu::ChosenFields> chosen = cpu::chosen_fields(scene, projection_.choice(), options, maker_);
    if (!chosen) return forward(chosen);
    const std::span<const int> layers = fields_.layers_of(*chosen);
    GridBlock block{};
    for (std::size_t i = 0; i < chosen->size(); ++i) {
      block.layer[i] = layers[i];
      const CameraField* field = (*chosen)[i].get();
      if (field == nullptr) continue;
      const std::size_t from = i / kMostListed;
      block.place[from] = field->place;
      block.size[from] = {static_cast<float>(field->width), static_cast<float>(field->height), 0, 0};
    }
    gl::upload(grids_, capacity_, &block, sizeof block);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, grids_.id());
    return {};
  }

  Projection projection_;
  Inspection inspection_;
  gl::Kernel blend_;
  cpu::FieldMaker maker_;
  FieldTextures fields_;
  gl::Buffer grids_;
  std::size_t capacity_ = 0;
  ViewTarget target_;
};

}  // namespace

Result<std::unique_ptr<ViewRenderer>> make_static_renderer() {
  return make_blending_pass<StaticRenderer>(
      "static.comp",
      {"view.glsl", "camera.glsl", "footprint.glsl", "positions.glsl", "false_color.glsl", "picture.glsl"});
}

}  // namespace floatstage::render
