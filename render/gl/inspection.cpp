#include "render/gl/inspection.h"

namespace floatstage::render {

Result<Inspection> Inspection::create() {
  Inspection inspection;
  Result<gl::Kernel> kernel = gl::Kernel::create(
      "inspect.comp",
      {"view.glsl", "camera.glsl", "footprint.glsl", "positions.glsl", "false_color.glsl", "picture.glsl"});
  if (!kernel) return forward(kernel);
  inspection.kernel_ = std::move(*kernel);
  return inspection;
}

void Inspection::draw(const Projection& projection, const SceneTextures& textures, const Scene& scene,
                      const View& view, const RendererOptions& options, const ViewTarget& target) {
  const Eigen::AlignedBox3f& box = textures.scene->box;
  const float middle =
      static_cast<float>((view.view_from_world * Eigen::Vector3d(box.center().cast<double>())).z());
  const float radius = 0.5F * box.diagonal().norm() + 1e-6F;
  kernel_.set(1, middle - radius, middle + radius)
      .set(2, shown_slots(scene, projection.choice(), options).camera)
      .set(3, static_cast<float>(options.uncertainty * static_cast<double>(box.diagonal().norm())));
  projection.draw(kernel_,
                  {&projection.surface(), &projection.weights(0), &projection.weights(1),
                   &projection.visibility(), &projection.soft(0), &projection.soft(1)},
                  target);
}

RenderedView rendered_view(const Scene& scene, const View& view, const Projection& projection,
                           const ViewTarget& target) {
  return {.texture = target.texture().id(),
          .width = view.model.width,
          .height = view.model.height,
          .seen_buffer = projection.seen(),
          .cameras = cameras_of(scene, projection.choice())};
}

}  // namespace floatstage::render
