#include "render/gl/floating_renderer.h"

#include <algorithm>
#include <optional>
#include <vector>

#include "core/log.h"
#include "core/text.h"
#include "render/cpu/common_displacement.h"
#include "render/cpu/projection.h"
#include "render/depth_windows.h"
#include "render/gl/field_memory.h"
#include "render/gl/floating_flow.h"
#include "render/gl/inspection.h"
#include "render/gl/projection.h"
#include "render/gl_context.h"
#include "render/pairwise_flows.h"
#include "render/projected_images.h"
#include "render/stage_times.h"

namespace floatstage::render {
namespace {

constexpr int kMargin = 16;  // px around the view: what the warps may pull in from outside

constexpr float kLeastFade = 1e-4F;  // shaders/float.comp has the same: a fainter camera pulls nothing

class FloatingRenderer : public ViewRenderer {
 public:
  FloatingRenderer(Projection projection, Inspection inspection, gl::Kernel project, gl::Kernel composite,
                   FieldMemory memory)
      : projection_(std::move(projection)),
        inspection_(std::move(inspection)),
        project_(std::move(project)),
        float_(std::move(composite)),
        memory_(std::move(memory)),
        software_(is_software_gl()) {}

  Result<RenderedView> render(const Scene& scene, const View& view, const RendererOptions& options) override {
    if (Result<void> ok = check_render(scene, view, options); !ok) return forward(ok);
    const Result<const SceneTextures*> textures = SceneTextures::of(scene);
    if (!textures) return forward(textures);
    projection_.run(**textures, view, options, kMargin, false);
    target_.begin(view.model.width, view.model.height);
    if (projection_.window().empty()) {
      target_.clear(options.background);
    } else {
      if (is_shared_intermediate(options.output)) {
        inspection_.draw(projection_, **textures, scene, view, options, target_);
      } else {
        StageTimes::enter("images");
        project_images(options.fill_hidden);
        const bool by_depth = finds_depth(options, flows_on_gpu(options.flow)) && count() > 1;
        if (Result<void> ok = by_depth ? find_displacement(scene, view, options) : estimate_flows(options);
            !ok)
          return forward(ok);
        const gl::Texture* flows = &flows_;
        if (options.field_memory > 0 && count() > 1 && !by_depth)
          flows = &memory_.mix(scene, view, projection_, pulling(), options.flow.shrink, options.field_memory,
                               flows_);
        const ShownSlots shown = shown_slots(scene, projection_.choice(), options);
        StageTimes::enter("blending");
        float_.set(1, static_cast<int>(options.positions))
            .set(2, shown.camera, shown.towards)
            .set(3, options.shown_camera < 0 ? 1 : 0)
            .set(4, by_depth ? 1 : 0);
        projection_.draw(float_,
                         {&projection_.surface(), &projection_.weights(0), &projection_.weights(1), &images_,
                          flows, &projection_.angular(0), &projection_.angular(1), &projection_.soft(0),
                          &projection_.soft(1), &confidence_, &displacement_},
                         target_);
      }
      projection_.soften(**textures, options, target_);
    }
    return rendered_view(scene, view, projection_, target_);
  }
  void reset_history() override {
    memory_.forget();
    common_.forget();
  }

 private:
  int count() const { return static_cast<int>(projection_.choice().chosen); }

  void project_images(bool fill_hidden) {
    const Window& w = projection_.window();
    images_.reserve(GL_RGBA8, GL_LINEAR, w.width, w.height, count());
    project_.set(0, fill_hidden ? 1 : 0);
    projection_.on_window(
        project_,
        {&projection_.surface(), &projection_.weights(0), &projection_.weights(1), &projection_.visibility()},
        {&images_});
  }

  /// The images for the flow: grey, and at 1/shrink of their size.
  ProjectedImages read_images(int shrink) const {
    const Window& w = projection_.window();
    const auto layers = static_cast<std::size_t>(count());
    const std::size_t size = static_cast<std::size_t>(w.width) * static_cast<std::size_t>(w.height);
    std::vector<std::uint8_t> rgba(size * 4 * layers);
    glGetTextureSubImage(images_.id(), 0, 0, 0, 0, w.width, w.height, count(), GL_RGBA, GL_UNSIGNED_BYTE,
                         static_cast<GLsizei>(rgba.size()), rgba.data());
    return projected_images(rgba, w.width, w.height, count(), shrink);
  }

  /// Which images' ideas of a position count: the others need no field towards them.
  std::vector<bool> pulling() const {
    const CameraChoice& choice = projection_.choice();
    std::vector<bool> pulls(choice.chosen);
    for (std::size_t i = 0; i < choice.chosen; ++i) pulls[i] = choice.fade[i] >= kLeastFade;
    if (std::find(pulls.begin(), pulls.end(), true) == pulls.end()) pulls.assign(choice.chosen, true);
    return pulls;
  }

  bool flows_on_gpu(const FlowOptions& flow) const {
    return count() >= 2 && flow.backend == "variational" &&
           (flow.place == FlowPlace::Gpu || (flow.place == FlowPlace::Auto && !software_));
  }

  /// As the CPU's renderer finds them, from the surface that was drawn here.
  Result<void> find_displacement(const Scene& scene, const View& view, const RendererOptions& options) {
    const Window& w = projection_.window();
    const std::size_t width = static_cast<std::size_t>(w.width),
                      size = width * static_cast<std::size_t>(w.height);
    surface_.resize(4 * size);
    glGetTextureSubImage(projection_.surface().id(), 0, 0, 0, 0, w.width, w.height, 1, GL_RGBA, GL_FLOAT,
                         static_cast<GLsizei>(surface_.size() * sizeof(float)), surface_.data());
    inverse_z_.resize(size);
    for (std::size_t i = 0; i < size; ++i)
      inverse_z_[i] = surface_[4 * i + 3] > 0 ? 1 / surface_[4 * i + 3] : 0;
    const ProjectedImages images = read_images(options.flow.shrink);
    cpu::CommonDisplacement::Picture picture{&scene.impl(),
                                             scene.impl().on_gpu,
                                             cpu::view_rays(view, w),
                                             {},
                                             &projection_.choice(),
                                             inverse_z_.data(),
                                             w.width,
                                             w.height,
                                             static_cast<float>(depth_tolerance(scene.impl().box)),
                                             &images};
    for (std::size_t i = 0; i < projection_.choice().chosen; ++i) {
      const auto camera = static_cast<std::size_t>(projection_.choice().listed[i]);
      const Eigen::Vector3f center = scene.impl().cameras[camera].cam_from_world.center().cast<float>();
      picture.centers[i] = cpu::center_in_view(picture.rays, {center.x(), center.y(), center.z()});
    }
    const Result<void> found = common_.run(
        picture,
        [&](int y, cpu::SurfaceRow& row) {
          row.count = 0;
          const float* from = surface_.data() + 4 * width * static_cast<std::size_t>(y);
          for (int x = 0; x < w.width; ++x, from += 4) {
            if (!(from[3] > 0)) continue;
            const auto k = static_cast<std::size_t>(row.count++);
            row.x[k] = static_cast<float>(x) + 0.5F;
            row.inverse_z[k] = 1 / from[3];
            row.nx[k] = from[0];
            row.ny[k] = from[1];
            row.nz[k] = from[2];
          }
        },
        options);
    if (!found) return found;
    if (options.field_memory > 0) common_.remember(picture, options);
    displacement_.reserve(GL_R32F, GL_LINEAR, images.width, images.height, 1);
    glTextureSubImage3D(displacement_.id(), 0, 0, 0, 0, images.width, images.height, 1, GL_RED, GL_FLOAT,
                        common_.displacement().data());
    if (options.output == RenderOutput::Confidence) {
      confidence_.reserve(GL_R8, GL_NEAREST, images.width, images.height, 1);
      glTextureSubImage3D(confidence_.id(), 0, 0, 0, 0, images.width, images.height, 1, GL_RED,
                          GL_UNSIGNED_BYTE, common_.believed().data());
    }
    return {};
  }

  Result<void> estimate_flows(const RendererOptions& options) {
    const bool keeps = options.output == RenderOutput::Confidence;  // which only fields of the CPU have
    pairwise_.keep_confidence(keeps);
    if (!keeps && flows_on_gpu(options.flow)) {
      const Result<void> made = make_computed();
      if (made) return compute_flows(options.flow);
      if (options.flow.place == FlowPlace::Gpu) return made;
      log::warning(text("the flow stays on the CPU: ", made.error().message));
      software_ = true;
    }
    const Window& w = projection_.window();
    const int shrink = options.flow.shrink, width = (w.width + shrink - 1) / shrink,
              height = (w.height + shrink - 1) / shrink;
    flows_.reserve(GL_RG32F, GL_LINEAR, width, height, std::max(count() * (count() - 1), 1));
    if (count() < 2) return {};
    const ProjectedImages images = read_images(shrink);
    const Result<void> made = pairwise_.estimate(images, pulling(), options.flow, options.threads);
    if (!made) return made;
    for (std::size_t pair = 0; pair < pairwise_.fields().size(); ++pair)
      glTextureSubImage3D(flows_.id(), 0, 0, 0, static_cast<GLint>(pair), width, height, 1, GL_RG, GL_FLOAT,
                          pairwise_.fields()[pair].uv.data());
    if (keeps) upload_confidence(width, height);
    return {};
  }

  void upload_confidence(int width, int height) {
    confidence_.reserve(GL_R8, GL_NEAREST, width, height, std::max(count() * (count() - 1), 1));
    const std::vector<std::uint8_t> unknown(static_cast<std::size_t>(width) *
                                            static_cast<std::size_t>(height));
    for (std::size_t pair = 0; pair < pairwise_.confidence().size(); ++pair) {
      const std::vector<std::uint8_t>& known = pairwise_.confidence()[pair];
      glTextureSubImage3D(confidence_.id(), 0, 0, 0, static_cast<GLint>(pair), width, height, 1, GL_RED,
                          GL_UNSIGNED_BYTE, (known.empty() ? unknown : known).data());
    }
  }

  Result<void> make_computed() {
    if (computed_) return {};
    Result<FloatingFlow> made = FloatingFlow::create(FlowPrecision::Half);
    if (!made) return forward(made);
    computed_ = std::move(*made);
    return {};
  }

  Result<void> compute_flows(const FlowOptions& flow) {
    const Window& w = projection_.window();
    return computed_->run(images_, w.width, w.height, pulling(), flow, flows_);
  }

  Projection projection_;
  Inspection inspection_;
  gl::Kernel project_, float_;
  FieldMemory memory_;
  gl::Texture images_, flows_, confidence_, displacement_;
  ViewTarget target_;
  bool software_;                           // what draws; or the flow does not run on what does
  std::vector<float> surface_, inverse_z_;  // read back for …
  cpu::CommonDisplacement common_;          // … these
  PairwiseFlows pairwise_;                  // on the CPU …
  std::optional<FloatingFlow> computed_;    // … or on the GPU: made when first used
};

}  // namespace

Result<std::unique_ptr<ViewRenderer>> make_floating_renderer() {
  Result<Projection> projection = Projection::create();
  if (!projection) return forward(projection);
  Result<Inspection> inspection = Inspection::create();
  if (!inspection) return forward(inspection);
  Result<gl::Kernel> project =
      gl::Kernel::create("project.comp", {"view.glsl", "camera.glsl", "footprint.glsl", "window.glsl"});
  if (!project) return forward(project);
  Result<gl::Kernel> composite = gl::Kernel::create(
      "float.comp",
      {"view.glsl", "camera.glsl", "footprint.glsl", "positions.glsl", "false_color.glsl", "picture.glsl"});
  if (!composite) return forward(composite);
  Result<FieldMemory> memory = FieldMemory::create();
  if (!memory) return forward(memory);
  return std::unique_ptr<ViewRenderer>(
      std::make_unique<FloatingRenderer>(std::move(*projection), std::move(*inspection), std::move(*project),
                                         std::move(*composite), std::move(*memory)));
}

}  // namespace floatstage::render
