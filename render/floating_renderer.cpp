#include "render/floating_renderer.h"

#include <algorithm>
#include <optional>

#include "core/parallel.h"
#include "render/image_fill.h"
#include "render/inspection.h"
#include "render/projection.h"

namespace floatstage {
namespace {

constexpr int kMargin = 16;  // px around the view: what the warps may pull in from outside

/// Grey pictures of the intermediate images, continued beyond the proxy, and whether each camera counts anywhere.
struct FlowInputs {
  int width = 0, height = 0;
  std::vector<std::vector<std::uint8_t>> gray;
};

class FloatingRenderer : public ViewRenderer {
 public:
  FloatingRenderer(Projection projection, Inspection inspection, gl::Program project, gl::Program composite)
      : projection_(std::move(projection)),
        inspection_(std::move(inspection)),
        project_(std::move(project)),
        float_(std::move(composite)),
        images_target_(gl::Framebuffer::create()) {}

  Result<RenderedView> render(const SceneTextures& scene, const View& view, const RendererOptions& options) override {
    if (Result<void> ok = check_render(scene, view, options); !ok) return forward(ok);
    projection_.run(scene, view, options, kMargin, false);
    const Window& w = projection_.window();
    target_.begin(view.model.width, view.model.height, options.background);
    if (!w.empty()) {
      if (inspection_.shows(options.output)) {
        inspection_.draw(projection_, scene, view, target_);
      } else {
        project_images();
        if (Result<void> ok = estimate_flows(options); !ok) return forward(ok);
        glUseProgram(float_.id());
        glUniform2i(0, w.x, w.y);
        projection_.draw_at(target_.framebuffer(), float_,
                            {projection_.surface(), projection_.weights(0), projection_.weights(1), images_.id(),
                             flows_.id()},
                            w.x, w.y, w.width, w.height);
      }
    }
    return rendered_view(scene, view, projection_, target_);
  }

 private:
  int count() const { return static_cast<int>(projection_.choice().chosen); }

  void project_images() {
    const Window& w = projection_.window();
    if (images_.reserve(GL_RGBA8, GL_LINEAR, w.width, w.height, count()))
      for (int i = 0; i < kMostListed; ++i)
        glNamedFramebufferTextureLayer(images_target_.id(), GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(i),
                                       i < count() ? images_.id() : 0, 0, i);
    set_draw_buffers(images_target_, count());
    projection_.draw(images_target_.id(), project_,
                     {projection_.surface(), projection_.weights(0), projection_.weights(1), projection_.visibility()});
  }

  FlowInputs read_images() const {
    const Window& w = projection_.window();
    FlowInputs in{w.width, w.height, {}};
    const std::size_t size = static_cast<std::size_t>(w.width) * w.height;
    std::vector<std::uint8_t> rgba(size * 4 * static_cast<std::size_t>(count()));
    glGetTextureSubImage(images_.id(), 0, 0, 0, 0, w.width, w.height, count(), GL_RGBA, GL_UNSIGNED_BYTE,
                         static_cast<GLsizei>(rgba.size()), rgba.data());
    in.gray.assign(static_cast<std::size_t>(count()), std::vector<std::uint8_t>(size));
    parallel_for(in.gray.size(), 0, [&](std::size_t layer) {
      const std::uint8_t* from = rgba.data() + layer * size * 4;
      std::vector<std::uint8_t> mask(size);
      for (std::size_t i = 0; i < size; ++i) {
        mask[i] = from[4 * i + 3];
        in.gray[layer][i] = static_cast<std::uint8_t>((77 * from[4 * i] + 150 * from[4 * i + 1] + 29 * from[4 * i + 2] + 128) >> 8);
      }
      fill_unknown(w.width, w.height, mask.data(), in.gray[layer].data());
    });
    return in;
  }

  /// All ordered pairs of the chosen images, in parallel; every pair has its own estimator, so the result does not
  /// depend on which thread takes it.
  Result<void> estimate_flows(const RendererOptions& options) {
    const Window& w = projection_.window();
    const int n = count(), pairs = n * (n - 1);
    flows_.reserve(GL_RG32F, GL_LINEAR, w.width, w.height, std::max(pairs, 1));
    if (pairs == 0) return {};
    if (!flow_options_ || *flow_options_ != options.flow) estimators_.clear();
    flow_options_ = options.flow;
    while (estimators_.size() < static_cast<std::size_t>(pairs)) {
      auto estimator = make_flow_estimator(options.flow);
      if (!estimator) return forward(estimator);
      estimators_.push_back(std::move(*estimator));
    }
    const FlowInputs in = read_images();
    std::vector<Result<FlowField>> fields(static_cast<std::size_t>(pairs), Result<FlowField>(FlowField{}));
    parallel_for(fields.size(), 0, [&](std::size_t pair) {
      const std::size_t i = pair / static_cast<std::size_t>(n - 1), rest = pair % static_cast<std::size_t>(n - 1);
      const std::size_t j = rest < i ? rest : rest + 1;
      fields[pair] = estimators_[pair]->estimate({in.width, in.height, in.gray[i].data()},
                                                 {in.width, in.height, in.gray[j].data()});
    });
    for (std::size_t pair = 0; pair < fields.size(); ++pair) {
      if (!fields[pair]) return forward(fields[pair]);
      glTextureSubImage3D(flows_.id(), 0, 0, 0, static_cast<GLint>(pair), w.width, w.height, 1, GL_RG, GL_FLOAT,
                          fields[pair]->uv.data());
    }
    return {};
  }

  Projection projection_;
  Inspection inspection_;
  gl::Program project_, float_;
  gl::Texture images_, flows_;
  gl::Framebuffer images_target_;
  ViewTarget target_;
  std::optional<FlowOptions> flow_options_;
  std::vector<std::unique_ptr<FlowEstimator>> estimators_;
};

}  // namespace

Result<std::unique_ptr<ViewRenderer>> make_floating_renderer() {
  Result<Projection> projection = Projection::create();
  if (!projection) return forward(projection);
  Result<Inspection> inspection = Inspection::create();
  if (!inspection) return forward(inspection);
  Result<gl::Program> project = gl::make_program("fullscreen.vert", "project.frag", {"view.glsl", "camera.glsl"});
  if (!project) return forward(project);
  Result<gl::Program> composite =
      gl::make_program("fullscreen.vert", "float.frag", {"view.glsl", "camera.glsl", "false_color.glsl"});
  if (!composite) return forward(composite);
  return std::unique_ptr<ViewRenderer>(std::make_unique<FloatingRenderer>(
      std::move(*projection), std::move(*inspection), std::move(*project), std::move(*composite)));
}

}  // namespace floatstage
