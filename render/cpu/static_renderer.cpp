// Floating Textures for scenes at rest (Eq. 11.4): photographs displaced by fields that were estimated in the
// cameras' own pictures, and blended as "linear" does. The pass of render/gl/shaders/static.comp.
#include <array>
#include <span>

#include "render/cpu/false_color.h"
#include "render/cpu/field_kernels.h"
#include "render/cpu/field_maker.h"
#include "render/cpu/inspection.h"
#include "render/cpu/position_shares.h"
#include "render/cpu/renderers.h"
#include "render/cpu/row_mean.h"
#include "render/renderer_checks.h"

namespace floatstage::render::cpu {
namespace {

constexpr float kOffSubject = 0.1F;  // what colours weigh that no matte calls the subject's

class StaticRenderer : public ViewRenderer {
 public:
  Result<RenderedView> render(const Scene& scene, const View& view, const RendererOptions& options) override {
    if (Result<void> ok = check_render(scene, view, options); !ok) return forward(ok);
    if (Result<void> ok = check_output("floating-static", options.output); !ok) return forward(ok);
    if (Result<void> ok = projection_.run(scene, view, options, {.mattes = has_soft_outline(options)}); !ok)
      return forward(ok);
    picture_.begin(view, options.background);
    if (!projection_.window().empty()) {
      if (is_shared_intermediate(options.output)) {
        draw_intermediate(projection_, scene, view, options, picture_);
      } else {
        Result<ChosenFields> fields = chosen_fields(scene, projection_.choice(), options, maker_);
        if (!fields) return forward(fields);
        fields_ = std::move(*fields);
        if (options.positions == Positions::Parallax) centers_ = centers_in_view(projection_);
        projection_.for_rows([&](int y, RowMemory& memory) { float_row(y, options, memory); });
      }
      if (Result<void> ok = picture_.soften(projection_, options); !ok) return forward(ok);
    }
    return rendered_view(scene, view, projection_, picture_);
  }

 private:
  FieldPulls pulls_of(std::size_t image, const PositionShares& shares) const;
  void float_row(int y, const RendererOptions& options, RowMemory& memory);

  Projection projection_;
  Picture picture_;
  FieldMaker maker_;
  CentersInView centers_{};
  ChosenFields fields_;
};

FieldPulls StaticRenderer::pulls_of(std::size_t image, const PositionShares& shares) const {
  FieldPulls pulls;
  for (std::size_t to = 0; to < projection_.choice().chosen; ++to) {
    const CameraField* field = fields_[static_cast<std::size_t>(kMostListed) * image + to].get();
    if (field == nullptr) continue;
    pulls.place = field->place;
    pulls.width = field->width;
    pulls.height = field->height;
    pulls.uv[static_cast<std::size_t>(pulls.count)] = field->uv.data();
    pulls.pulls[static_cast<std::size_t>(pulls.count++)] = shares.follow[to];
  }
  return pulls;
}

void StaticRenderer::float_row(int y, const RendererOptions& options, RowMemory& memory) {
  const Covered::Row& row = projection_.covered().rows[static_cast<std::size_t>(y)];
  const auto count = static_cast<std::size_t>(row.count);
  const std::size_t chosen = projection_.choice().chosen, listed = projection_.choice().listed.size();
  const PositionShares shares =
      position_shares(projection_, y, options.positions == Positions::Parallax ? &centers_ : nullptr, memory);
  RowMean mean(count, kFaint, memory);
  float *u = memory.floats(count), *v = memory.floats(count);
  std::int32_t *inside = memory.ints(count), *wanted = memory.ints(count);
  std::array<RowShare, kMostListed> drawn{};
  std::array<float*, kMostListed> moved_x{}, moved_y{};
  const PixelList points{projection_.covered().x.data() + row.list, nullptr,
                         projection_.covered().inverse_z.data() + row.list, static_cast<float>(y) + 0.5F,
                         row.count};
  for (std::size_t slot = 0; slot < listed; ++slot) {
    const float* weight = projection_.weight(slot) + row.list;
    if (slot < chosen) {
      moved_x[slot] = memory.floats(count);
      moved_y[slot] = memory.floats(count);
    }
    const bool shown = slot < chosen && options.output == RenderOutput::Flow;
    if (!mark_weighty(weight, kFaint, count, wanted) && !shown) continue;
    float *color = memory.floats(4 * count), *used = memory.floats(count);
    if (slot < chosen)
      float_points(projection_.camera(slot), projection_.rays(), points, pulls_of(slot, shares), u, v, inside,
                   moved_x[slot], moved_y[slot]);
    else
      project_points(projection_.camera(slot), projection_.rays(), points, u, v, inside);
    projection_.read(slot, row, u, v, wanted, color, memory);
    for (std::size_t k = 0; k < count; ++k) {
      if (wanted[k] == 0) {
        used[k] = 0;
        continue;
      }
      // What the fields bring may lie off the subject: the point that is here does not.
      used[k] = weight[k] * (kOffSubject + color[4 * k + 3] / 255);
    }
    mean.add(drawn[slot] = {used, color});
  }
  if (options.output != RenderOutput::Flow) {
    picture_.write(projection_, y,
                   mean.finish(options.output == RenderOutput::Ghosting, std::span(drawn).first(listed)), 4);
    return;
  }
  float* rgb = memory.floats(3 * count);
  for (std::size_t k = 0; k < count; ++k) {
    std::size_t strongest = 0;
    for (std::size_t i = 1; i < chosen; ++i)
      if (shares.pull[i][k] > shares.pull[strongest][k]) strongest = i;
    const std::array<float, 3> color = flow_color(moved_x[strongest][k], moved_y[strongest][k]);
    std::copy(color.begin(), color.end(), rgb + 3 * k);
  }
  picture_.write(projection_, y, rgb, 3);
}

}  // namespace

Result<std::unique_ptr<ViewRenderer>> make_static_renderer() {
  return std::unique_ptr<ViewRenderer>(std::make_unique<StaticRenderer>());
}

}  // namespace floatstage::render::cpu
