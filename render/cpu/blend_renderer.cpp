// The weighted mean of the projected photographs (Eq. 9.1), or how far they disagree. The pass of
// render/gl/shaders/blend.comp.
#include <array>
#include <span>

#include "core/text.h"
#include "render/cpu/inspection.h"
#include "render/cpu/renderers.h"
#include "render/cpu/row_mean.h"
#include "render/renderer_checks.h"

namespace floatstage::render::cpu {
namespace {

class BlendRenderer : public ViewRenderer {
 public:
  explicit BlendRenderer(bool one_camera) : one_camera_(one_camera) {}

  Result<RenderedView> render(const Scene& scene, const View& view, const RendererOptions& options) override {
    if (Result<void> ok = check_render(scene, view, options); !ok) return forward(ok);
    if (Result<void> ok = check_output(one_camera_ ? "nearest" : "linear", options.output); !ok)
      return forward(ok);
    const Projection::Wanted wanted{
        .margin = 0, .one_camera = one_camera_, .mattes = has_soft_outline(options)};
    if (Result<void> ok = projection_.run(scene, view, options, wanted); !ok) return forward(ok);
    picture_.begin(view, options.background);
    if (!projection_.window().empty()) {
      if (is_shared_intermediate(options.output))
        draw_intermediate(projection_, scene, view, options, picture_);
      else
        projection_.for_rows([&](int y, RowMemory& memory) {
          blend_row(y, options.output == RenderOutput::Ghosting, memory);
        });
      if (Result<void> ok = picture_.soften(projection_, options); !ok) return forward(ok);
    }
    return rendered_view(scene, view, projection_, picture_);
  }

 private:
  void blend_row(int y, bool ghosting, RowMemory& memory) {
    const Covered::Row& row = projection_.covered().rows[static_cast<std::size_t>(y)];
    const auto count = static_cast<std::size_t>(row.count);
    const std::size_t listed = projection_.choice().listed.size();
    RowMean mean(count, kFaint, memory);
    float *u = memory.floats(count), *v = memory.floats(count);
    std::int32_t *inside = memory.ints(count), *wanted = memory.ints(count);
    std::array<RowShare, kMostListed> shares{};
    const PixelList points{projection_.covered().x.data() + row.list, nullptr,
                           projection_.covered().inverse_z.data() + row.list, static_cast<float>(y) + 0.5F,
                           row.count};
    for (std::size_t slot = 0; slot < listed; ++slot) {
      const float* weight = projection_.weight(slot) + row.list;
      if (!mark_weighty(weight, kFaint, count, wanted)) continue;
      float* color = memory.floats(4 * count);
      project_points(projection_.camera(slot), projection_.rays(), points, u, v, inside);
      projection_.read(slot, row, u, v, wanted, color, memory);
      mean.add(shares[slot] = {weight, color});
    }
    picture_.write(projection_, y, mean.finish(ghosting, std::span(shares).first(listed)), 4);
  }

  const bool one_camera_;
  Projection projection_;
  Picture picture_;
};

}  // namespace

Result<std::unique_ptr<ViewRenderer>> make_blend_renderer(bool one_camera) {
  return std::unique_ptr<ViewRenderer>(std::make_unique<BlendRenderer>(one_camera));
}

std::string description() {
  return text("CPU, ", instruction_set(), ", ", default_threads(),
              default_threads() == 1 ? " core" : " cores");
}

}  // namespace floatstage::render::cpu
