#include "render/gl/inspection.h"

namespace floatstage::render {

Result<Inspection> Inspection::create() {
  Inspection inspection;
  Result<gl::Program> program =
      gl::make_program("fullscreen.vert", "inspect.frag",
                       {"view.glsl", "camera.glsl", "footprint.glsl", "positions.glsl", "false_color.glsl"});
  if (!program) return forward(program);
  inspection.program_ = std::move(*program);
  return inspection;
}

void Inspection::draw(const Projection& projection, const SceneTextures& textures, const Scene& scene,
                      const View& view, const RendererOptions& options, const ViewTarget& target) const {
  const Eigen::AlignedBox3f& box = textures.scene->box;
  const float middle =
      static_cast<float>((view.view_from_world * Eigen::Vector3d(box.center().cast<double>())).z());
  const float radius = 0.5F * box.diagonal().norm() + 1e-6F;
  const Window& w = projection.window();
  glUseProgram(program_.id());
  glUniform2i(0, w.x, w.y);
  glUniform2f(1, middle - radius, middle + radius);
  glUniform1i(2, shown_slots(scene, projection.choice(), options).camera);
  glUniform1f(3, static_cast<float>(options.uncertainty * static_cast<double>(box.diagonal().norm())));
  projection.draw_at(target.framebuffer(), program_,
                     {projection.surface(), projection.weights(0), projection.weights(1),
                      projection.visibility(), projection.soft(0), projection.soft(1)},
                     w.x, w.y, w.width, w.height);
}

RenderedView rendered_view(const Scene& scene, const View& view, const Projection& projection,
                           const ViewTarget& target) {
  return {.texture = target.texture(),
          .width = view.model.width,
          .height = view.model.height,
          .cameras = cameras_of(scene, projection.choice())};
}

}  // namespace floatstage::render
