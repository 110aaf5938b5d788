// Figure 58: what visibility is worth where one surface hides another (§11.3, Eq. 11.5).
#include "core/text.h"
#include "pipeline/evaluate/evaluate.h"
#include "pipeline/film.h"
#include "pipeline/metrics/metrics.h"
#include "pipeline/reproduce/ball_before_wall.h"
#include "pipeline/reproduce/experiment.h"
#include "pipeline/reproduce/sheet.h"

namespace floatstage::pipeline {
namespace {

struct Variant {
  const char* visibility;
  bool soft, filled;
  std::string name() const {
    return std::string(soft ? "soft" : "binary") + (filled ? "-filled" : "-not-filled");
  }
};
constexpr Variant kVariants[] = {
    {"binary", false, false}, {"binary", false, true}, {"soft", true, false}, {"soft", true, true}};

render::RendererOptions renderer_of(const Variant& variant, const Lab& lab) {
  render::RendererOptions options;
  options.back_end = lab.back_end;
  if (!variant.soft) options.soft_radius = 0;
  options.fill_hidden = variant.filled;
  return options;
}

// The maps that Figure 58c to f shows, of one view.
Result<SheetRow> maps_of(const TestScene& scene, const RigCamera& view, const Lab& lab) {
  render::Scene drawn;
  if (Result<void> ok = drawn.set(scene.rig, scene.photographs); !ok) return forward(ok);
  Result<std::unique_ptr<render::ViewRenderer>> renderer = render::make_renderer("floating", lab.back_end);
  if (!renderer) return forward(renderer);
  SheetRow row;
  struct Map {
    const char* name;
    render::RenderOutput output;
    bool soft;
  };
  for (const Map& map : {Map{"visibility", render::RenderOutput::Visibility, false},
                         Map{"soft visibility", render::RenderOutput::SoftVisibility, true},
                         Map{"weights binary", render::RenderOutput::Weights, false},
                         Map{"weights soft", render::RenderOutput::Weights, true}}) {
    render::RendererOptions options = renderer_of({"", map.soft, true}, lab);
    options.output = map.output;
    const Result<render::RenderedView> picture =
        (*renderer)->render(drawn, view_of_camera(view, scene.photographs.mesh), options);
    if (!picture) return forward(picture);
    row.push_back({map.name, over(render::download(*picture), {0, 0, 0})});
  }
  return row;
}

}  // namespace

Result<Outcome> run_fig58(const Lab& lab) {
  const TestScene scene =
      ball_before_wall({.width = lab.size(480), .height = lab.size(360), .views = lab.views(3)});
  const std::size_t middle = 0;
  const Image about = about_occlusions(scene, scene.views[middle].camera);
  Outcome outcome;
  outcome.table = {
      "Figure 58: visibility",
      text("a ball before a wall, four cameras unequal by 10 % and 1.5 px, a proxy too large and "
           "too far away; psnr_hidden: in the parts of the wall that not all cameras see and 8 px about, ",
           scene.views.size(), " views"),
      {"method", "visibility", "occluded"},
      {"psnr_mask", "psnr_hidden", "ssim_mask", "sharpness"},
      {}};
  std::vector<SheetRow> rows(2);
  PictureWindow close;
  for (const std::string& method : {std::string("linear"), std::string("floating")})
    for (const Variant& variant : kVariants) {
      if (method == "linear" && !variant.filled) continue;  // it seeks no flow: nothing is filled
      const Result<std::vector<ComparedView>> views = compare(scene, {.methods = {method},
                                                                      .renderer = renderer_of(variant, lab),
                                                                      .ghosting = false,
                                                                      .what = "fig58",
                                                                      .progress = lab.progress});
      if (!views) return forward(views);
      double hidden = 0;
      for (std::size_t v = 0; v < views->size(); ++v) {
        Image mask = about_occlusions(scene, scene.views[v].camera);
        for (std::size_t i = 0; i < mask.pixels.size(); ++i)
          if ((*views)[v].mask.pixels[i] < 128) mask.pixels[i] = 0;
        hidden += psnr((*views)[v].rendered.at(method), (*views)[v].truth, mask) /
                  static_cast<double>(views->size());
      }
      const MethodScores s = mean_of(*views, method);
      outcome.table.rows.push_back({{method, variant.visibility,
                                     method == "linear" ? "–"
                                     : variant.filled   ? "filled"
                                                        : "not filled"},
                                    {s.psnr, hidden, s.ssim, s.sharpness}});
      if (method == "linear") continue;
      const ComparedView& shown = (*views)[middle];
      const Image& picture = shown.rendered.at(method);
      if (rows[0].empty()) {
        close = worst_window(picture, shown.truth, about, about.width / 5);
        rows[0].push_back({"truth", shown.truth});
        rows[1].push_back({"truth", cut(shown.truth, close, 5)});
      }
      rows[0].push_back({variant.name(), picture});
      rows[1].push_back({variant.name(), cut(picture, close, 5)});
    }
  Result<SheetRow> maps = maps_of(scene, scene.views[middle].camera, lab);
  if (!maps) return forward(maps);
  rows.push_back(std::move(*maps));
  outcome.sheet = sheet_of(rows);
  return outcome;
}

}  // namespace floatstage::pipeline
