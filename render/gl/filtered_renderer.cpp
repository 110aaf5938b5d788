#include "render/gl/filtered_renderer.h"

#include <array>
#include <memory>

#include "render/gl/inspection.h"
#include "render/gl/projection.h"

namespace floatstage::render {
namespace {

// The pictures before, in 32-bit floats: an 8-bit history would stop short of what rests.
class History {
 public:
  static Result<History> create() {
    History h;
    Result<gl::Program> fade = gl::make_program("fullscreen.vert", "fade.frag", {"view.glsl"});
    if (!fade) return forward(fade);
    h.fade_ = std::move(*fade);
    for (gl::Framebuffer& f : h.targets_) f = gl::Framebuffer::create();
    h.shown_target_ = gl::Framebuffer::create();
    return h;
  }

  void forget() { size_ = {0, 0}; }

  /// Mixes `now` into what was before; the texture to show.
  GLuint mix(const Projection& projection, GLuint now, int width, int height, float share) {
    const bool first = size_ != std::array<int, 2>{width, height};
    size_ = {width, height};
    for (std::size_t i = 0; i < 2; ++i)
      if (sums_[i].resize(GL_RGBA32F, GL_NEAREST, width, height))
        glNamedFramebufferTexture(targets_[i].id(), GL_COLOR_ATTACHMENT0, sums_[i].id(), 0);
    if (shown_.resize(GL_RGBA8, GL_LINEAR, width, height))
      glNamedFramebufferTexture(shown_target_.id(), GL_COLOR_ATTACHMENT0, shown_.id(), 0);
    const std::size_t to = 1 - last_;
    glProgramUniform1f(fade_.id(), 0, first ? 0 : share);
    projection.draw_at(targets_[to].id(), fade_, {now, sums_[last_].id()}, 0, 0, width, height);
    glProgramUniform1f(fade_.id(), 0, 0);
    projection.draw_at(shown_target_.id(), fade_, {sums_[to].id(), sums_[last_].id()}, 0, 0, width, height);
    last_ = to;
    return shown_.id();
  }

 private:
  gl::Program fade_;
  std::array<gl::Texture, 2> sums_;
  std::array<gl::Framebuffer, 2> targets_;
  gl::Texture shown_;
  gl::Framebuffer shown_target_;
  std::array<int, 2> size_ = {0, 0};
  std::size_t last_ = 0;
};

class FilteredRenderer : public ViewRenderer {
 public:
  FilteredRenderer(Projection projection, Inspection inspection, gl::Program blend, History history)
      : projection_(std::move(projection)),
        inspection_(std::move(inspection)),
        blend_(std::move(blend)),
        history_(std::move(history)) {}

  Result<RenderedView> render(const Scene& scene, const View& view, const RendererOptions& options) override {
    if (Result<void> ok = check_render(scene, view, options); !ok) return forward(ok);
    if (Result<void> ok = check_output("filtered", options.output); !ok) return forward(ok);
    const Result<const SceneTextures*> textures = SceneTextures::of(scene);
    if (!textures) return forward(textures);
    projection_.run(**textures, view, options, 0, false, true);
    target_.begin(view.model.width, view.model.height, options.background);
    if (const Window& w = projection_.window(); !w.empty()) {
      if (is_shared_intermediate(options.output))
        inspection_.draw(projection_, **textures, scene, view, options, target_);
      else
        draw(scene.impl(), options, w);
      projection_.soften(**textures, options, target_);
    }
    RenderedView drawn = rendered_view(scene, view, projection_, target_);
    if (options.output == RenderOutput::Color && options.motion_blur > 0)
      drawn.texture = history_.mix(projection_, target_.texture(), drawn.width, drawn.height,
                                   static_cast<float>(options.motion_blur));
    else
      history_.forget();
    return drawn;
  }

  void reset_history() override { history_.forget(); }

 private:
  void draw(const Scene::Impl& s, const RendererOptions& options, const Window& w) {
    glProgramUniform2i(blend_.id(), 0, w.x, w.y);
    glProgramUniform1f(
        blend_.id(), 1,
        static_cast<float>(options.uncertainty * static_cast<double>(s.box.diagonal().norm())));
    projection_.draw_at(target_.framebuffer(), blend_,
                        {projection_.surface(), projection_.weights(0), projection_.weights(1)}, w.x, w.y,
                        w.width, w.height);
  }

  Projection projection_;
  Inspection inspection_;
  gl::Program blend_;
  History history_;
  ViewTarget target_;
};

}  // namespace

Result<std::unique_ptr<ViewRenderer>> make_filtered_renderer() {
  Result<Projection> projection = Projection::create();
  if (!projection) return forward(projection);
  Result<Inspection> inspection = Inspection::create();
  if (!inspection) return forward(inspection);
  Result<gl::Program> blend = gl::make_program(
      "fullscreen.vert", "filtered.frag", {"view.glsl", "camera.glsl", "footprint.glsl", "false_color.glsl"});
  if (!blend) return forward(blend);
  Result<History> history = History::create();
  if (!history) return forward(history);
  return std::unique_ptr<ViewRenderer>(std::make_unique<FilteredRenderer>(
      std::move(*projection), std::move(*inspection), std::move(*blend), std::move(*history)));
}

}  // namespace floatstage::render
