// Warps the intermediate images onto one another and blends them (Eq. 11.2, 11.3). The pass of
// render/gl/shaders/float.comp.
#include <algorithm>
#include <cmath>

#include "render/cpu/common_displacement.h"
#include "render/cpu/field_memory.h"
#include "render/cpu/floating_inspection.h"
#include "render/cpu/inspection.h"
#include "render/cpu/position_shares.h"
#include "render/cpu/renderers.h"
#include "render/cpu/warp_kernels.h"
#include "render/cpu/weight_kernels.h"
#include "render/flow/gray_samples.h"
#include "render/pairwise_flows.h"
#include "render/renderer_checks.h"

namespace floatstage::render::cpu {
namespace {

constexpr int kMargin = 16;  // px around the view: what the warps may pull in from outside

class FloatingRenderer : public ViewRenderer {
 public:
  Result<RenderedView> render(const Scene& scene, const View& view, const RendererOptions& options) override {
    if (Result<void> ok = check_render(scene, view, options); !ok) return forward(ok);
    const bool intermediate = is_shared_intermediate(options.output);
    const Projection::Wanted wanted{.margin = kMargin,
                                    .images = !intermediate,
                                    .mattes = has_soft_outline(options),
                                    .fill = options.fill_hidden};
    if (Result<void> ok = projection_.run(scene, view, options, wanted); !ok) return forward(ok);
    picture_.begin(view, options.background);
    parallax_ = options.positions == Positions::Parallax;
    if (!projection_.window().empty()) {
      const bool remembers = options.field_memory > 0 && !intermediate && count() > 1;
      if (intermediate) {
        draw_intermediate(projection_, scene, view, options, picture_);
      } else {
        centers_ = centers_in_view(projection_);
        by_depth_ = finds_depth(options) && count() > 1;
        if (Result<void> ok = by_depth_ ? find_displacement(scene, options) : estimate_flows(options); !ok)
          return forward(ok);
        shown_ = shown_slots(scene, projection_.choice(), options);
        if (remembers && !by_depth_)
          memory_.mix(scene, projection_, pulls_, options.flow.shrink, options.field_memory,
                      pairwise_.fields());
        projection_.for_rows([&](int y, RowMemory& rows) { float_row(y, options, rows); });
      }
      if (Result<void> ok = picture_.soften(projection_, options); !ok) return forward(ok);
      if (remembers) remember(scene, options);
    }
    return rendered_view(scene, view, projection_, picture_);
  }
  void reset_history() override {
    memory_.forget();
    common_.forget();
  }

 private:
  // Of one row; lists of an image each.
  struct Lists {
    PositionShares share;
    std::array<float*, kMostListed> rgba{}, used{}, hidden{}, from_x{}, from_y{};
  };

  std::size_t count() const { return projection_.choice().chosen; }
  Result<void> estimate_flows(const RendererOptions& options);
  CommonDisplacement::Picture seen(const Scene& scene) const;
  Result<void> find_displacement(const Scene& scene, const RendererOptions& options);
  void remember(const Scene& scene, const RendererOptions& options);
  void place_images(int y, const RendererOptions& options, Lists& lists, RowMemory& memory);
  void let_filled_in(std::size_t pixels, Lists& lists) const;
  void warp_image(std::size_t image, int y, const RendererOptions& options, Lists& lists, RowMemory& memory);
  void float_image(std::size_t image, int y, Lists& lists, RowMemory& memory);
  void float_row(int y, const RendererOptions& options, RowMemory& memory);

  Projection projection_;
  Picture picture_;
  ProjectedImages images_;
  std::vector<bool> pulls_;
  PairwiseFlows pairwise_;
  FieldMemory memory_;
  CommonDisplacement common_;
  CentersInView centers_{};
  ShownSlots shown_;
  bool parallax_ = true, by_depth_ = false;
};

Result<void> FloatingRenderer::estimate_flows(const RendererOptions& options) {
  if (count() < 2) return {};
  pulls_.resize(count());
  for (std::size_t i = 0; i < count(); ++i) pulls_[i] = projection_.choice().fade[i] >= kLeastFade;
  if (std::find(pulls_.begin(), pulls_.end(), true) == pulls_.end()) pulls_.assign(count(), true);
  projection_.gray_images(options.flow.shrink, images_);
  pairwise_.keep_confidence(options.output == RenderOutput::Confidence);
  return pairwise_.estimate(images_, pulls_, options.flow, options.threads, &projection_.interruption());
}

CommonDisplacement::Picture FloatingRenderer::seen(const Scene& scene) const {
  return {&scene.impl(),
          scene.impl().on_cpu,
          projection_.rays(),
          centers_,
          &projection_.choice(),
          projection_.inverse_z(),
          projection_.window().width,
          projection_.window().height,
          projection_.tolerance(),
          &images_};
}

Result<void> FloatingRenderer::find_displacement(const Scene& scene, const RendererOptions& options) {
  projection_.gray_images(options.flow.shrink, images_);
  const Covered& covered = projection_.covered();
  return common_.run(
      seen(scene),
      [&](int y, SurfaceRow& out) {
        const Covered::Row& row = covered.rows[static_cast<std::size_t>(y)];
        out.count = row.count;
        if (row.count == 0) return;
        std::copy_n(covered.x.data() + row.list, row.count, out.x.data());
        std::copy_n(covered.inverse_z.data() + row.list, row.count, out.inverse_z.data());
        projection_.write_normals(y, out.nx.data(), out.ny.data(), out.nz.data());
      },
      options, &projection_.interruption());
}

void FloatingRenderer::remember(const Scene& scene, const RendererOptions& options) {
  if (by_depth_) return common_.remember(seen(scene), options);
  memory_.keep(scene, projection_, pulls_, options.flow.shrink, pairwise_.fields());
}

// Where the chosen cameras see little of what arrives, the images of those that do not see it count, which
// hold the blend of all that do.
void FloatingRenderer::let_filled_in(std::size_t pixels, Lists& lists) const {
  for (std::size_t k = 0; k < pixels; ++k) {
    float seen = 0, hidden = 0;
    for (std::size_t i = 0; i < count(); ++i) {
      seen += lists.used[i][k];
      hidden += lists.hidden[i][k];
    }
    if (seen >= kEnough || hidden <= 0) continue;
    const float share = (kEnough - seen) / hidden;
    for (std::size_t i = 0; i < count(); ++i) lists.used[i][k] += share * lists.hidden[i][k];
  }
}

// Where image `image` is read for the pixels of row y.
void FloatingRenderer::warp_image(std::size_t image, int y, const RendererOptions& options, Lists& lists,
                                  RowMemory& memory) {
  const Covered::Row& row = projection_.covered().rows[static_cast<std::size_t>(y)];
  const auto pixels = static_cast<std::size_t>(row.count);
  WarpFields fields;
  for (std::size_t j = 0; j < count(); ++j) {
    if (j == image) continue;
    const FlowField& field = pairwise_.fields()[image * (count() - 1) + (j < image ? j : j - 1)];
    fields.uv[static_cast<std::size_t>(fields.count)] = field.uv.data();
    fields.pulls[static_cast<std::size_t>(fields.count++)] = lists.share.follow[j];
    fields.width = field.width;
    fields.height = field.height;
  }
  fields.shrink = static_cast<float>(options.flow.shrink);
  WarpedRow warped;
  warped.count = row.count;
  warped.x = projection_.covered().x.data() + row.list;
  warped.y = static_cast<float>(y) + 0.5F;
  warped.from_x = lists.from_x[image] = memory.floats(pixels);
  warped.from_y = lists.from_y[image] = memory.floats(pixels);
  if (fields.count > 0) return invert_warps(fields, warped);
  std::copy_n(warped.x, pixels, warped.from_x);
  std::fill_n(warped.from_y, pixels, warped.y);
}

// Where all images are read, by the one displacement that they share.
void FloatingRenderer::place_images(int y, const RendererOptions& options, Lists& lists, RowMemory& memory) {
  const Covered::Row& row = projection_.covered().rows[static_cast<std::size_t>(y)];
  const auto pixels = static_cast<std::size_t>(row.count);
  const float* x = projection_.covered().x.data() + row.list;
  const auto shrink = static_cast<float>(options.flow.shrink);
  const float at_y = (static_cast<float>(y) + 0.5F) / shrink - 0.5F;
  float* displacement = memory.floats(pixels);
  for (std::size_t k = 0; k < pixels; ++k)
    displacement[k] = shrink * bilinear_sample(common_.displacement().data(), images_.width, images_.height,
                                               x[k] / shrink - 0.5F, at_y);
  for (std::size_t i = 0; i < count(); ++i) {
    lists.from_x[i] = memory.floats(pixels);
    lists.from_y[i] = memory.floats(pixels);
  }
  place_at_depth(projection_.rays(), centers_, lists.share.row, {common_.share().data(), count()},
                 displacement, lists.from_x, lists.from_y);
}

void FloatingRenderer::float_image(std::size_t image, int y, Lists& lists, RowMemory& memory) {
  const Covered::Row& row = projection_.covered().rows[static_cast<std::size_t>(y)];
  const auto pixels = static_cast<std::size_t>(row.count);
  WarpSource source;
  source.width = projection_.window().width;
  source.height = projection_.window().height;
  source.inverse_z = projection_.inverse_z();
  source.own = projection_.own();
  source.image = projection_.image(image);
  source.soft = projection_.soft_plane(image);
  source.slot = static_cast<int>(image);
  source.tolerance = projection_.tolerance();
  WarpedRow warped;
  warped.count = row.count;
  warped.x = projection_.covered().x.data() + row.list;
  warped.y = static_cast<float>(y) + 0.5F;
  warped.from_x = lists.from_x[image];
  warped.from_y = lists.from_y[image];
  warped.inverse_z = memory.floats(pixels);
  warped.direct = memory.ints(pixels);
  warped.seen = memory.floats(pixels);
  float *u = memory.floats(pixels), *v = memory.floats(pixels);
  std::int32_t* inside = memory.ints(pixels);
  lists.rgba[image] = memory.floats(4 * pixels);
  lists.used[image] = memory.floats(pixels);

  look_up(source, warped);
  project_points(projection_.camera(image), projection_.rays(),
                 {warped.from_x, warped.from_y, warped.inverse_z, 0, row.count}, u, v, inside);
  for (std::size_t k = 0; k < pixels; ++k) warped.direct[k] &= inside[k];
  projection_.read(image, row, u, v, warped.direct, lists.rgba[image], memory);
  borrow_colors(source, warped, lists.rgba[image]);
  lists.hidden[image] = memory.floats(pixels);
  for (std::size_t k = 0; k < pixels; ++k) {
    const float pull = lists.share.pull[image][k] >= kFaintShare ? lists.share.pull[image][k] : 0;
    // What matters is whether camera i sees the point whose colour arrives here, not the point that is here.
    lists.used[image][k] = pull * warped.seen[k];
    lists.hidden[image][k] = pull - lists.used[image][k];
  }
}

void FloatingRenderer::float_row(int y, const RendererOptions& options, RowMemory& memory) {
  const Covered::Row& row = projection_.covered().rows[static_cast<std::size_t>(y)];
  const auto pixels = static_cast<std::size_t>(row.count);
  Lists lists;
  lists.share = position_shares(projection_, y, parallax_ ? &centers_ : nullptr, memory);
  if (by_depth_) place_images(y, options, lists, memory);
  for (std::size_t i = 0; i < count() && !by_depth_; ++i) warp_image(i, y, options, lists, memory);
  if (parallax_ && !by_depth_ && count() > 1)
    lean_on_depth(projection_.rays(), centers_, lists.share.row,
                  {lists.share.pull, lists.from_x, lists.from_y});
  for (std::size_t i = 0; i < count(); ++i) float_image(i, y, lists, memory);
  let_filled_in(pixels, lists);
  float* mean = memory.floats(3 * pixels);
  for (std::size_t k = 0; k < pixels; ++k) {
    float sum[3] = {0, 0, 0}, total = 0;
    for (std::size_t i = 0; i < count(); ++i) {
      const float used = lists.used[i][k];
      if (used == 0) continue;
      for (std::size_t c = 0; c < 3; ++c) sum[c] += used * lists.rgba[i][4 * k + c];
      total += used;
    }
    for (std::size_t c = 0; c < 3; ++c) mean[3 * k + c] = sum[c] / total;
  }
  float* shown = mean;
  if (is_floating_intermediate(options.output)) {
    shown = memory.floats(3 * pixels);
    FloatedRow floated{lists.share, lists.rgba, lists.used, lists.from_x, lists.from_y, mean};
    if (by_depth_) {
      floated.believed = common_.believed().data();
      floated.width = images_.width;
    }
    float_intermediate(projection_, pairwise_, options, shown_, y, floated, shown, memory);
  }
  picture_.write(projection_, y, shown, 3);
}

}  // namespace

Result<std::unique_ptr<ViewRenderer>> make_floating_renderer() {
  return std::unique_ptr<ViewRenderer>(std::make_unique<FloatingRenderer>());
}

}  // namespace floatstage::render::cpu
