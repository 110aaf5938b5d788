#include "render/gl/filtered_renderer.h"

#include <array>
#include <memory>

#include "render/gl/inspection.h"
#include "render/gl/projection.h"
#include "render/stage_times.h"

namespace floatstage::render {
namespace {

// The pictures before, in 32-bit floats: an 8-bit history would stop short of what rests.
class History {
 public:
  static Result<History> create() {
    History h;
    Result<gl::Kernel> fade = gl::Kernel::create("fade.comp", {});
    if (!fade) return forward(fade);
    h.fade_ = std::move(*fade);
    return h;
  }

  void forget() { size_ = {0, 0}; }

  /// Mixes `now` into what was before: what to show.
  const gl::Texture& mix(const gl::Texture& now, float share) {
    const int width = now.width(), height = now.height();
    const bool first = size_ != std::array<int, 2>{width, height};
    size_ = {width, height};
    for (gl::Texture& sum : sums_) sum.resize(GL_RGBA32F, GL_NEAREST, width, height);
    shown_.resize(GL_RGBA8, GL_LINEAR, width, height);
    const std::size_t to = 1 - last_;
    fade_.set(0, first ? 0 : share);
    fade_.over(width, height, {&now, &sums_[last_]}, {&sums_[to], &shown_});
    last_ = to;
    return shown_;
  }

 private:
  gl::Kernel fade_;
  std::array<gl::Texture, 2> sums_;
  gl::Texture shown_;
  std::array<int, 2> size_ = {0, 0};
  std::size_t last_ = 0;
};

class FilteredRenderer : public ViewRenderer {
 public:
  FilteredRenderer(Projection projection, Inspection inspection, gl::Kernel blend, History history)
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
    target_.begin(view.model.width, view.model.height);
    if (projection_.window().empty()) {
      target_.clear(options.background);
    } else {
      if (is_shared_intermediate(options.output))
        inspection_.draw(projection_, **textures, scene, view, options, target_);
      else
        draw(scene.impl(), options);
      projection_.soften(**textures, options, target_);
    }
    RenderedView drawn = rendered_view(scene, view, projection_, target_);
    if (options.output == RenderOutput::Color && options.motion_blur > 0)
      drawn.texture = history_.mix(target_.texture(), static_cast<float>(options.motion_blur)).id();
    else
      history_.forget();
    return drawn;
  }

  void reset_history() override { history_.forget(); }

 private:
  void draw(const Scene::Impl& s, const RendererOptions& options) {
    StageTimes::enter("blending");
    blend_.set(1, static_cast<float>(options.uncertainty * static_cast<double>(s.box.diagonal().norm())));
    projection_.draw(blend_, {&projection_.surface(), &projection_.weights(0), &projection_.weights(1)},
                     target_);
  }

  Projection projection_;
  Inspection inspection_;
  gl::Kernel blend_;
  History history_;
  ViewTarget target_;
};

}  // namespace

Result<std::unique_ptr<ViewRenderer>> make_filtered_renderer() {
  Result<Projection> projection = Projection::create();
  if (!projection) return forward(projection);
  Result<Inspection> inspection = Inspection::create();
  if (!inspection) return forward(inspection);
  Result<gl::Kernel> blend = gl::Kernel::create(
      "filtered.comp", {"view.glsl", "camera.glsl", "footprint.glsl", "false_color.glsl", "picture.glsl"});
  if (!blend) return forward(blend);
  Result<History> history = History::create();
  if (!history) return forward(history);
  return std::unique_ptr<ViewRenderer>(std::make_unique<FilteredRenderer>(
      std::move(*projection), std::move(*inspection), std::move(*blend), std::move(*history)));
}

}  // namespace floatstage::render
