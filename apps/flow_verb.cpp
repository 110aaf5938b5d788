#include <cstdio>
#include <ctime>

#include <nlohmann/json.hpp>

#include "apps/terminal/flags.h"
#include "apps/verbs.h"
#include "core/png.h"
#include "core/text.h"
#include "pipeline/json_report.h"
#include "render/flow.h"
#include "render/flow/flo_file.h"
#include "render/flow/flow_score.h"

namespace floatstage::apps {
namespace {

namespace fs = std::filesystem;

struct FlowArguments {
  fs::path first, second, truth, out, picture, json_file;
  std::string backend = "variational", preset = "quality";
  int finest_scale = 0;
};

struct Estimate {
  render::FlowField field;
  double seconds = 0;  // of the processor, reading the files left out
};

// DIS has no "quality"; its most careful preset is "medium".
render::FlowOptions flow_options(const FlowArguments& given) {
  render::FlowOptions options;
  options.backend = given.backend;
  options.preset = given.backend == "dis" && given.preset == "quality" ? "medium" : given.preset;
  options.finest_scale = given.finest_scale;
  return options;
}

Result<Estimate> estimate(const FlowArguments& given, const render::FlowField* truth) {
  const auto estimator = render::make_flow_estimator(flow_options(given));
  if (!estimator) return forward(estimator);
  const Result<Image> first = load_png(given.first);
  if (!first) return forward(first);
  const Result<Image> second = load_png(given.second);
  if (!second) return forward(second);
  const auto differs = [&](const fs::path& file, int width, int height) {
    return fail(ErrorCode::InvalidArgument,
                text(file.string(), " has ", width, "x", height, " px and ", given.first.string(), " ",
                     first->width, "x", first->height, "; optical flow wants one size"));
  };
  if (first->width != second->width || first->height != second->height)
    return differs(given.second, second->width, second->height);
  if (truth != nullptr && (truth->width != first->width || truth->height != first->height))
    return differs(given.truth, truth->width, truth->height);
  const std::vector<std::uint8_t> a = render::flow_gray(*first), b = render::flow_gray(*second);
  const std::clock_t begin = std::clock();
  Result<render::FlowField> field = render::estimate_flow(
      **estimator, {first->width, first->height, a.data()}, {second->width, second->height, b.data()});
  if (!field) return forward(field);
  return Estimate{std::move(*field), static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC};
}

Result<void> run_flow(const FlowArguments& given) {
  std::optional<render::FlowField> truth;
  if (!given.truth.empty()) {
    Result<render::FlowField> loaded = render::load_flo(given.truth);
    if (!loaded) return forward(loaded);
    truth = std::move(*loaded);
  }
  const Result<Estimate> found = estimate(given, truth ? &*truth : nullptr);
  if (!found) return forward(found);
  nlohmann::json report = {{"seconds", found->seconds}};
  if (truth) {
    const Result<render::FlowScore> score = render::score_flow(found->field, *truth);
    if (!score) return forward(score);
    report.update({{"epe", score->epe}, {"aae", score->aae}, {"known", score->known}});
    std::printf("end-point error %.4f px, angular error %.3f degrees over %zu known pixels, ", score->epe,
                score->aae, score->known);
  }
  std::printf("%.3f s of the processor\n", found->seconds);
  if (!given.out.empty())
    if (Result<void> ok = render::save_flo(found->field, given.out); !ok) return ok;
  if (!given.picture.empty())
    if (Result<void> ok = save_png(render::flow_picture(found->field), given.picture); !ok) return ok;
  return given.json_file.empty() ? Result<void>() : pipeline::save_json(report, given.json_file);
}

}  // namespace

void add_flow(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<FlowArguments>();
  CLI::App* verb = add_verb(
      app, chosen, "flow", "Optical flow from one picture to another, scored where the truth is known",
      {"floatstage flow first.png second.png --truth truth.flo --json scores.json",
       "floatstage flow first.png second.png --flow dis --preset fast -o field.flo --picture field.png"});
  verb->add_option("first", options->first, "PNG that is looked from")->required()->type_name("PNG");
  verb->add_option("second", options->second, "PNG of the same size that is looked into")
      ->required()
      ->type_name("PNG");
  verb->add_option("--flow", options->backend, "Flow back-end: variational or dis")
      ->capture_default_str()
      ->check(one_of(render::flow_backends()).description(""));
  verb->add_option("--preset", options->preset, "How much time it may take")
      ->capture_default_str()
      ->check(one_of({"quality", "fast"}));
  verb->add_option("--truth", options->truth, "True field (.flo) to be scored against")->type_name("FILE");
  add_out(*verb, options->out, "Where the field goes (.flo)");
  verb->add_option("--picture", options->picture,
                   "Write the field in colours to this PNG: hue is its direction, paleness its shortness")
      ->type_name("FILE");
  verb->add_option("--flow-finest-scale", options->finest_scale,
                   "Pyramid level at which the flow stops; 0: full resolution")
      ->capture_default_str()
      ->group(kGroupTuning);
  add_json(*verb, options->json_file);
  verb->callback([options, &chosen] { chosen.run = [options] { return run_flow(*options); }; });
}

}  // namespace floatstage::apps
