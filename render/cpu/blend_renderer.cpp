// The weighted mean of the projected photographs (Eq. 9.1), or how far they disagree. The pass of
// render/gl/shaders/blend.frag.
#include <algorithm>

#include "core/text.h"
#include "render/cpu/picture.h"
#include "render/cpu/renderers.h"
#include "render/renderer_checks.h"

namespace floatstage::render::cpu {
namespace {

constexpr float kFaint = 1e-4F;  // below half an 8-bit step even against the strongest contrast

class BlendRenderer : public ViewRenderer {
 public:
  explicit BlendRenderer(bool one_camera) : one_camera_(one_camera) {}

  Result<RenderedView> render(const Scene& scene, const View& view, const RendererOptions& options) override {
    if (Result<void> ok = check_render(scene, view, options); !ok) return forward(ok);
    if (options.output == RenderOutput::Flow)
      return fail(ErrorCode::InvalidArgument,
                  "only the floating renderer has a flow to show; choose another output");
    projection_.run(scene, view, options, {.margin = 0, .one_camera = one_camera_});
    picture_.begin(view, options.background);
    if (!projection_.window().empty()) {
      if (is_shared_intermediate(options.output))
        draw_intermediate(projection_, scene, view, options.output, picture_);
      else
        projection_.for_rows([&](int y, RowMemory& memory) {
          blend_row(y, options.output == RenderOutput::Ghosting, memory);
        });
    }
    return rendered_view(scene, view, projection_, picture_);
  }

 private:
  void blend_row(int y, bool ghosting, RowMemory& memory) {
    const Covered::Row& row = projection_.covered().rows[static_cast<std::size_t>(y)];
    const auto count = static_cast<std::size_t>(row.count);
    const std::size_t listed = projection_.choice().listed.size();
    float *u = memory.floats(count), *v = memory.floats(count), *sum = memory.floats(4 * count);
    float* total = memory.floats(count);
    std::int32_t *inside = memory.ints(count), *wanted = memory.ints(count);
    std::array<float*, kMostListed> colors{};
    std::fill_n(sum, 4 * count, 0.F);
    std::fill_n(total, count, 0.F);
    const PixelList points{projection_.covered().x.data() + row.list, nullptr,
                           projection_.covered().inverse_z.data() + row.list, static_cast<float>(y) + 0.5F,
                           row.count};
    for (std::size_t slot = 0; slot < listed; ++slot) {
      const float* weight = projection_.weight(slot) + row.list;
      colors[slot] = memory.floats(4 * count);
      std::int32_t any = 0;
      for (std::size_t i = 0; i < count; ++i) any |= wanted[i] = weight[i] >= kFaint ? 1 : 0;
      if (any == 0) continue;
      project_points(projection_.camera(slot), projection_.rays(), points, u, v, inside);
      read_colors(projection_.camera(slot), projection_.sharp(), u, v, wanted, row.count, colors[slot]);
      for (std::size_t i = 0; i < count; ++i) {
        if (wanted[i] == 0) continue;
        for (std::size_t c = 0; c < 3; ++c) sum[4 * i + c] += weight[i] * colors[slot][4 * i + c];
        total[i] += weight[i];
      }
    }
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t c = 0; c < 3; ++c) sum[4 * i + c] /= std::max(total[i], 1e-6F);
    if (ghosting) show_ghosts(projection_, row, colors, kFaint, total, sum);
    picture_.write(projection_, y, sum, 4);
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
