// What the methods make of worse and worse material: one thing is changed, all else stays.
#include "core/text.h"
#include "pipeline/reproduce/bunny.h"
#include "pipeline/reproduce/chart.h"
#include "pipeline/reproduce/dancer.h"
#include "pipeline/reproduce/experiment.h"
#include "recon/mesh/simplify.h"

namespace floatstage::pipeline {
namespace {

constexpr double kUncertainty = 0.0063, kBandLimit = 12;  // Table 3
constexpr double kGridStep = 10;                          // degrees
constexpr int kManyCameras = 16;

// Collects the rows of a sweep, and draws its chart.
class Sweep {
 public:
  Sweep(std::string title, std::string setup, std::string changed, std::vector<std::string> methods,
        const Lab& lab)
      : lab_(lab), methods_(std::move(methods)) {
    outcome_.table = {
        std::move(title), std::move(setup), {changed, "method"}, {"psnr_mask", "ssim_mask", "sharpness"}, {}};
    chart_ = {outcome_.table.title, std::move(changed), "PSNR, dB", {}, {}};
    for (const std::string& method : methods_) chart_.lines.push_back({method, {}});
  }

  render::RendererOptions renderer() const {
    render::RendererOptions options;
    options.back_end = lab_.back_end;
    return options;
  }
  Result<void> add(const std::string& value, const TestScene& scene,
                   const render::RendererOptions& renderer) {
    const Result<std::vector<ComparedView>> views =
        compare(scene, {.methods = methods_,
                        .renderer = renderer,
                        .ghosting = false,
                        .what = outcome_.table.words.front() + " " + value,
                        .progress = lab_.progress});
    if (!views) return forward(views);
    chart_.places.push_back(value);
    for (std::size_t m = 0; m < methods_.size(); ++m) {
      const MethodScores s = mean_of(*views, methods_[m]);
      outcome_.table.rows.push_back({{value, methods_[m]}, {s.psnr, s.ssim, s.sharpness}});
      chart_.lines[m].values.push_back(s.psnr);
    }
    return {};
  }
  Outcome end() {
    outcome_.chart = to_svg(chart_);
    return std::move(outcome_);
  }

 private:
  const Lab& lab_;
  std::vector<std::string> methods_;
  Outcome outcome_;
  Chart chart_;
};

render::RendererOptions with_table3(render::RendererOptions options, const Lab& lab) {
  options.uncertainty = kUncertainty;
  options.band_limit = lab.small ? kBandLimit / 2 : kBandLimit;
  return options;
}

// In the middle of the grid's cells around its centre.
std::vector<RigCamera> in_cells(double step, int count, int size) {
  std::vector<RigCamera> views;
  for (const auto& [x, y] : {std::pair(-1, 1), std::pair(1, -1), std::pair(1, 1), std::pair(-1, -1)})
    if (static_cast<int>(views.size()) < count)
      views.push_back(bunny_camera(0.5 * step * x, 15 + 0.5 * step * y, size));
  return views;
}

Result<Bunny> bunny_of(const Lab& lab) { return load_bunny(lab.data / "stanford-bunny"); }

DancerOptions dancer_of(const Lab& lab, int cameras = 8) {
  return {.cameras = cameras,
          .views = lab.views(4),
          .width = lab.size(640),
          .height = lab.size(480),
          .defects = {},
          .progress = lab.progress};
}

}  // namespace

Result<Outcome> sweep_triangles(const Lab& lab) {
  const Result<Bunny> bunny = bunny_of(lab);
  if (!bunny) return forward(bunny);
  const int size = lab.size(512);
  TestScene scene = painted_bunny(bunny->exact, bunny->exact, bunny_grid(4, kGridStep, size),
                                  in_cells(2 * kGridStep, lab.views(4), size));
  Sweep sweep(
      "The proxy's triangles",
      "the bunny from 4 x 4 cameras 10 degrees apart; the scan itself, collapsed by quadric errors, and "
      "the scan's own 948",
      "triangles", compared_methods(false), lab);
  for (const int triangles : {0, 16000, 4000, 2000, 948}) {
    if (triangles == 948) {
      scene.photographs.mesh = bunny->coarse;
    } else if (triangles > 0) {
      Result<Mesh> fewer = recon::simplified(bunny->exact, triangles);
      if (!fewer) return forward(fewer);
      scene.photographs.mesh = std::move(*fewer);
    }
    if (Result<void> ok = sweep.add(text(scene.photographs.mesh.triangle_count()), scene,
                                    with_table3(sweep.renderer(), lab));
        !ok)
      return forward(ok);
  }
  return sweep.end();
}

Result<Outcome> sweep_spacing(const Lab& lab) {
  const Result<Bunny> bunny = bunny_of(lab);
  if (!bunny) return forward(bunny);
  const int size = lab.size(512);
  Sweep sweep("The cameras' distance",
              "the bunny on 948 triangles from 3 x 3 cameras; views in the middle of their cells", "degrees",
              compared_methods(false), lab);
  for (const int step : {5, 10, 15, 20, 30}) {
    const TestScene scene = painted_bunny(bunny->exact, bunny->coarse, bunny_grid(3, step, size),
                                          in_cells(step, lab.views(4), size));
    if (Result<void> ok = sweep.add(text(step), scene, with_table3(sweep.renderer(), lab)); !ok)
      return forward(ok);
  }
  return sweep.end();
}

Result<Outcome> sweep_calibration(const Lab& lab) {
  Sweep sweep(
      "Errors of calibration",
      "the studio's dancer, eight cameras, on the hull that the faulty calibration makes; r.m.s. an axis "
      "and camera",
      "px", compared_methods(false), lab);
  for (const double error : {0.0, 0.5, 1.0, 2.0, 4.0}) {
    DancerOptions options = dancer_of(lab);
    options.defects.calibration_error = error;
    const Result<TestScene> scene = dancer(options);
    if (!scene) return forward(scene);
    if (Result<void> ok = sweep.add(text(error), *scene, sweep.renderer()); !ok) return forward(ok);
  }
  return sweep.end();
}

Result<Outcome> sweep_gains(const Lab& lab) {
  Sweep sweep("Unequal cameras",
              "the studio's dancer, eight cameras; standard deviation of each channel's gain, not balanced",
              "percent", compared_methods(false), lab);
  for (const int percent : {0, 5, 10, 20}) {
    DancerOptions options = dancer_of(lab);
    options.defects.color_gain = percent / 100.0;
    const Result<TestScene> scene = dancer(options);
    if (!scene) return forward(scene);
    if (Result<void> ok = sweep.add(text(percent), *scene, sweep.renderer()); !ok) return forward(ok);
  }
  return sweep.end();
}

Result<Outcome> sweep_blend(const Lab& lab) {
  const Result<TestScene> scene = dancer(dancer_of(lab, kManyCameras));
  if (!scene) return forward(scene);
  Sweep sweep("Photographs in a view", "the studio's dancer, sixteen cameras", "blended",
              compared_methods(false), lab);
  for (const int blended : {1, 2, 3, 4, 6, 8}) {
    render::RendererOptions options = sweep.renderer();
    options.cameras = blended;
    if (Result<void> ok = sweep.add(text(blended), *scene, options); !ok) return forward(ok);
  }
  return sweep.end();
}

Result<Outcome> sweep_flow(const Lab& lab) {
  const Result<TestScene> scene = dancer(dancer_of(lab));
  if (!scene) return forward(scene);
  Sweep sweep("The flow's resolution",
              "the studio's dancer, eight cameras; flow at a part of the view's size", "one over",
              {"linear", "floating"}, lab);
  for (const int shrink : {1, 2, 4, 8}) {
    render::RendererOptions options = sweep.renderer();
    options.flow.shrink = shrink;
    if (Result<void> ok = sweep.add(text(shrink), *scene, options); !ok) return forward(ok);
  }
  return sweep.end();
}

}  // namespace floatstage::pipeline
