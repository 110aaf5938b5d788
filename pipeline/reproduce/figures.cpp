// The figures of chapters 10 and 11 that compare methods: 52 (with Table 3), 53 and 61.
#include <cmath>

#include "core/text.h"
#include "pipeline/reproduce/bunny.h"
#include "pipeline/reproduce/dancer.h"
#include "pipeline/reproduce/experiment.h"
#include "pipeline/reproduce/light_field_scene.h"
#include "pipeline/reproduce/sheet.h"

namespace floatstage::pipeline {
namespace {

constexpr double kUncertainty = 0.0063, kBandLimit = 12;  // Table 3: share of the box' diagonal, px
constexpr int kTable3Views = 19, kFigure61Views = 49;
constexpr std::uint64_t kCamerasSeed = 1, kFigure61Seed = 1;
constexpr double kApart52 = 4, kApart61 = 15;  // degrees from view to view
constexpr double kPlaneUncertainty = 0.05;     // docs/constants.md
constexpr std::size_t kGivenBack = 3;          // cameras whose photographs are asked for

const std::vector<std::string> kScores = {"psnr_mask", "ssim_mask", "sharpness", "ghosting"};

render::RendererOptions renderer_of(const Lab& lab) {
  render::RendererOptions options;
  options.back_end = lab.back_end;
  return options;
}

render::RendererOptions bunny_renderer(const Lab& lab) {
  render::RendererOptions options = renderer_of(lab);
  options.uncertainty = kUncertainty;
  options.band_limit = lab.small ? kBandLimit / 2 : kBandLimit;
  return options;
}

Table::Row row_of(std::vector<std::string> words, const MethodScores& s) {
  return {std::move(words), {s.psnr, s.ssim, s.sharpness, s.ghosting}};
}

void add_rows(const std::vector<ComparedView>& views, const std::vector<std::string>& methods,
              const std::vector<std::string>& words, Table& table) {
  for (const std::string& method : methods) {
    std::vector<std::string> cells = words;
    cells.push_back(method);
    table.rows.push_back(row_of(std::move(cells), mean_of(views, method)));
  }
}

// The views' rows, of as many of them as a sheet should have.
Image sheet_of_views(const std::vector<ComparedView>& views, const std::vector<std::string>& methods,
                     const std::string& worst_of) {
  constexpr std::size_t kMost = 3;
  std::vector<SheetRow> rows;
  for (std::size_t i = 0; i < std::min(views.size(), kMost); ++i)
    for (SheetRow& row : rows_of(views[i], methods, worst_of)) rows.push_back(std::move(row));
  return sheet_of(rows);
}

double nearest_degrees(const RigCamera& view, const std::vector<RigCamera>& cameras) {
  double nearest = 180;
  for (const RigCamera& camera : cameras) nearest = std::min(nearest, degrees_between(view, camera));
  return nearest;
}

}  // namespace

Result<Outcome> run_fig52(const Lab& lab) {
  const Result<Bunny> bunny = load_bunny(lab.data / "stanford-bunny");
  if (!bunny) return forward(bunny);
  const int size = lab.size(512);
  const std::vector<RigCamera> cameras = bunny_cameras(kTable3Views, kBunnyWindow, kCamerasSeed, size);
  const TestScene scene = painted_bunny(
      bunny->exact, bunny->coarse, cameras,
      bunny_views_between(cameras, kBunnyWindow, lab.views(12), kApart52, BetweenOrder::Random, size));
  ComparisonOptions options{.methods = compared_methods(false),
                            .renderer = bunny_renderer(lab),
                            .what = "fig52",
                            .progress = lab.progress};
  const Result<std::vector<ComparedView>> views = compare(scene, options);
  if (!views) return forward(views);
  options.ghosting = false;
  const Result<std::vector<ComparedView>> back = compare(at_its_cameras(scene, kGivenBack), options);
  if (!back) return forward(back);

  Outcome outcome;
  outcome.table = {
      "Table 3 and Figure 52: the Stanford bunny",
      text(bunny->coarse.triangle_count(), " triangles as proxy, ", kTable3Views, " photographs of ", size,
           " x ", size, " px from random directions of a window of 60 by 60 degrees, ", views->size(),
           " random views between three of them; uncertainty 0.63 %, band limit ",
           options.renderer.band_limit, " px; at_camera: dB of a photograph seen again from its own camera"),
      {"method"},
      kScores,
      {}};
  outcome.table.numbers.push_back("at_camera");
  add_rows(*views, options.methods, {}, outcome.table);
  for (std::size_t m = 0; m < options.methods.size(); ++m)
    outcome.table.rows[m].numbers.push_back(mean_of(*back, options.methods[m]).psnr);
  outcome.sheet = sheet_of_views(*views, options.methods, "linear");
  return outcome;
}

namespace {

ComparisonOptions light_field_options(const Lab& lab, const char* what) {
  ComparisonOptions options{.methods = compared_methods(true),
                            .renderer = renderer_of(lab),
                            .what = what,
                            .progress = lab.progress};
  options.renderer.cameras = 4;  // a cell of the grid has so many corners
  options.renderer.uncertainty = kPlaneUncertainty;
  return options;
}

}  // namespace

Result<Outcome> run_fig53(const Lab& lab) {
  const Result<LightField> field = load_light_field(lab.data / "lightfield-shop");
  if (!field) return forward(field);
  const ComparisonOptions options = light_field_options(lab, "fig53");
  Outcome outcome;
  outcome.table = {"Figure 53: a light field, thinned",
                   text("every second and every fourth of ", field->rig.cameras.size(),
                        " pictures, on the plane where neighbours agree best; views in the middle between "
                        "their cameras, a twelfth of the width along the sides left out"),
                   {"photographs", "method"},
                   kScores,
                   {}};
  std::vector<SheetRow> rows;
  for (const int step : {2, 4}) {
    Result<TestScene> scene = thinned(*field, step);
    if (!scene) return forward(scene);
    scene->views.resize(static_cast<std::size_t>(lab.views(static_cast<int>(scene->views.size()))));
    const Result<std::vector<ComparedView>> views = compare(*scene, options);
    if (!views) return forward(views);
    add_rows(*views, options.methods, {text(scene->rig.cameras.size())}, outcome.table);
    for (SheetRow& row : rows_of(views->front(), options.methods, "light-field"))
      rows.push_back(std::move(row));
  }
  outcome.sheet = sheet_of(rows);
  return outcome;
}

Result<Outcome> run_fig61_bunny(const Lab& lab) {
  const Result<Bunny> bunny = load_bunny(lab.data / "stanford-bunny");
  if (!bunny) return forward(bunny);
  const int size = lab.size(512);
  const std::vector<RigCamera> cameras = bunny_cameras(kFigure61Views, {}, kFigure61Seed, size),
                               from = bunny_views_between(cameras, {}, lab.views(4), kApart61,
                                                          BetweenOrder::FarthestFirst, size);
  const TestScene scene = painted_bunny(bunny->exact, bunny->coarse, cameras, from);
  const ComparisonOptions options{.methods = compared_methods(false),
                                  .renderer = bunny_renderer(lab),
                                  .what = "fig61/bunny",
                                  .progress = lab.progress};
  const Result<std::vector<ComparedView>> views = compare(scene, options);
  if (!views) return forward(views);
  Outcome outcome;
  outcome.table = {
      "Figure 61, first row: the Stanford bunny",
      text(bunny->coarse.triangle_count(), " triangles as proxy, ", kFigure61Views,
           " photographs from random directions; ", from.size(), " views ",
           std::lround(nearest_degrees(from.back(), cameras)), " to ",
           std::lround(nearest_degrees(from.front(), cameras)), " degrees from the nearest of them"),
      {"method"},
      kScores,
      {}};
  add_rows(*views, options.methods, {}, outcome.table);
  outcome.sheet = sheet_of_views(*views, options.methods, "linear");
  return outcome;
}

Result<Outcome> run_fig61_hull(const Lab& lab) {
  const Result<TestScene> scene = dancer({.views = lab.views(4),
                                          .width = lab.size(640),
                                          .height = lab.size(480),
                                          .defects = {},
                                          .progress = lab.progress});
  if (!scene) return forward(scene);
  const ComparisonOptions options{.methods = compared_methods(false),
                                  .renderer = renderer_of(lab),
                                  .what = "fig61/hull",
                                  .progress = lab.progress};
  const Result<std::vector<ComparedView>> views = compare(*scene, options);
  if (!views) return forward(views);
  Outcome outcome;
  outcome.table = {"Figure 61, second row: a dancer on an exact visual hull",
                   text("the synthetic studio: ", scene->rig.cameras.size(), " cameras in a full circle, ",
                        scene->photographs.mesh.triangle_count(), " triangles; ", views->size(),
                        " views in the middle between two cameras"),
                   {"method"},
                   kScores,
                   {}};
  add_rows(*views, options.methods, {}, outcome.table);
  outcome.sheet = sheet_of_views(*views, options.methods, "linear");
  return outcome;
}

Result<Outcome> run_fig61_light_field(const Lab& lab) {
  const Result<LightField> field = load_light_field(lab.data / "lightfield-shop");
  if (!field) return forward(field);
  Result<TestScene> scene = thinned(*field, 2);
  if (!scene) return forward(scene);
  // One view in the middle and one near a corner say what sixteen do.
  const std::size_t count = scene->views.size();
  scene->views = {scene->views[count / 2 + count / 8], scene->views.front()};
  const ComparisonOptions options = light_field_options(lab, "fig61/light_field");
  const Result<std::vector<ComparedView>> views = compare(*scene, options);
  if (!views) return forward(views);
  Outcome outcome;
  outcome.table = {
      "Figure 61, last row: a light field",
      text(scene->rig.cameras.size(), " pictures on a plane; two views in the middle between four of them"),
      {"method"},
      kScores,
      {}};
  add_rows(*views, options.methods, {}, outcome.table);
  outcome.sheet = sheet_of_views(*views, options.methods, "light-field");
  return outcome;
}

}  // namespace floatstage::pipeline
