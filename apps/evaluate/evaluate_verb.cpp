#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "apps/evaluate/evaluate.h"
#include "apps/evaluate/picture_sheet.h"
#include "apps/json_report.h"
#include "apps/progress.h"
#include "apps/renderer_options.h"
#include "apps/text_options.h"
#include "apps/verbs.h"
#include "core/file.h"
#include "core/png.h"
#include "core/text.h"
#include "render/gl_context.h"

namespace floatstage {
namespace {

using nlohmann::json;

struct Options {
  std::filesystem::path take, json_file, csv_file, sheet;
  std::string hold_out, methods = "nearest,linear,floating", frames = "0", hull_method = "octree";
  RendererFlags renderer;
  HullOptions hull;
};

struct Column {
  const char* name;
  double Scores::*score;
};
constexpr Column kColumns[] = {{"psnr_mask", &Scores::psnr}, {"ssim_mask", &Scores::ssim}, {"cw_ssim_mask", &Scores::cw_ssim},
                               {"psnr_shift_mask", &Scores::psnr_shift}, {"sharpness", &Scores::sharpness}, {"psnr_full", &Scores::psnr_full}};

struct Row {
  std::string serial;
  int frame;
  std::map<std::string, Scores> scores;
};

json to_json(const Scores& s) {
  json j;
  for (const Column& c : kColumns) j[c.name] = s.*c.score;
  return j;
}

Scores mean(const std::vector<Row>& rows, const std::string& method) {
  Scores m;
  for (const Column& c : kColumns) {
    double sum = 0;
    for (const Row& r : rows) sum += r.scores.at(method).*c.score;
    m.*c.score = sum / static_cast<double>(rows.size());
  }
  return m;
}

std::string to_csv(const std::vector<Row>& rows, const std::vector<std::string>& methods) {
  std::string csv = "frame,camera,method";
  for (const Column& c : kColumns) csv += text(",", c.name);
  csv += "\n";
  for (const Row& r : rows) {
    for (const std::string& m : methods) {
      csv += text(r.frame, ",", r.serial, ",", m);
      for (const Column& c : kColumns) csv += text(",", r.scores.at(m).*c.score);
      csv += "\n";
    }
  }
  return csv;
}

void print_table(const std::vector<Row>& rows, const std::vector<std::string>& methods) {
  std::printf("%-10s", "mean of");
  for (const Column& c : kColumns) std::printf(" %15s", c.name);
  std::printf("\n");
  for (const std::string& m : methods) {
    const Scores s = mean(rows, m);
    std::printf("%-10s", m.c_str());
    for (const Column& c : kColumns) std::printf(" %15.4f", s.*c.score);
    std::printf("\n");
  }
}

Result<void> save_reports(const Options& given, const std::vector<Row>& rows, const std::vector<std::string>& methods) {
  if (!given.json_file.empty()) {
    json j = {{"take", given.take.string()}, {"views", json::array()}};
    for (const std::string& m : methods) j["mean"][m] = to_json(mean(rows, m));
    for (const Row& r : rows) {
      json scores;
      for (const std::string& m : methods) scores[m] = to_json(r.scores.at(m));
      j["views"].push_back({{"camera", r.serial}, {"frame", r.frame}, {"scores", scores}});
    }
    if (Result<void> ok = save_json(j, given.json_file); !ok) return ok;
  }
  return given.csv_file.empty() ? Result<void>() : write_file(given.csv_file, to_csv(rows, methods));
}

Result<void> run(const Options& given) {
  EvaluateOptions options{.hold_out = split_list(given.hold_out), .methods = split_list(given.methods), .renderer = {}, .hull = given.hull};
  options.hull.method = given.hull_method == "octree" ? HullMethod::Octree : HullMethod::Exact;
  if (options.methods.empty()) return fail(ErrorCode::InvalidArgument, "--methods names none; see --help");
  Result<RendererOptions> renderer = renderer_options(given.renderer);
  if (!renderer) return forward(renderer);
  options.renderer = *renderer;
  Result<std::unique_ptr<TakeReader>> take = TakeReader::open(given.take);
  if (!take) return forward(take);
  Result<std::vector<int>> frames = parse_frames(given.frames, (*take)->frame_count());
  if (!frames) return forward(frames);
  options.frames = std::move(*frames);
  if (!given.sheet.empty())
    if (Result<void> ok = make_folder(given.sheet); !ok) return ok;
  Result<std::unique_ptr<GlContext>> gl = GlContext::headless();
  if (!gl) return forward(gl);

  std::vector<Row> rows;
  const std::size_t held = options.hold_out.empty() ? (*take)->rig().cameras.size() : options.hold_out.size();
  Progress progress("views", held * options.frames.size());
  Result<void> done = evaluate_take(**take, options, [&](HeldOutView view) -> Result<void> {
    progress.advance();
    if (!given.sheet.empty()) {
      const std::string name = text(view.serial, "-", view.frame, ".png");
      if (Result<void> ok = save_png(sheet_row(view, options.methods), given.sheet / name); !ok) return ok;
    }
    rows.push_back({std::move(view.serial), view.frame, std::move(view.scores)});
    return {};
  });
  if (!done) return done;
  print_table(rows, options.methods);
  return save_reports(given, rows, options.methods);
}

}  // namespace

void add_evaluate(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<Options>();
  CLI::App* verb = app.add_subcommand("evaluate", "Leave-one-out scores of the renderers on a processed take");
  verb->add_option("take", options->take, "The take's folder")->required();
  verb->add_option("--hold-out", options->hold_out, "Cameras, each left out in turn, separated by commas (default: every one)");
  verb->add_option("--methods", options->methods, method_help())->capture_default_str();
  verb->add_option("--frames", options->frames, "Frames of the take: 5, 2:10 or 2:10:4")->capture_default_str();
  // The reference by default: it is soft, so scores do not hang on how the outlines were made polygons.
  verb->add_option("--hull", options->hull_method, "Hull method: octree or exact")->capture_default_str()->check(CLI::IsMember({"octree", "exact"}));
  verb->add_option("--resolution", options->hull.resolution, "Octree: voxels along the hull's longest side")->capture_default_str();
  verb->add_option("--json", options->json_file, "Write the scores as JSON");
  verb->add_option("--csv", options->csv_file, "Write the scores as CSV");
  verb->add_option("--sheet", options->sheet, "Write a picture sheet a view to this folder: truth, methods, difference");
  add_renderer_flags(*verb, options->renderer);
  verb->callback([options, &chosen] { chosen.run = [options] { return run(*options); }; });
}

}  // namespace floatstage
