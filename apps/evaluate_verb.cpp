#include <algorithm>
#include <charconv>
#include <cstdio>
#include <map>

#include <nlohmann/json.hpp>

#include "apps/evaluate/matte_table.h"
#include "apps/evaluate/score_table.h"
#include "apps/plan/planned.h"
#include "apps/terminal/flags.h"
#include "apps/terminal/hull_flags.h"
#include "apps/terminal/label_flags.h"
#include "apps/terminal/orbit_flags.h"
#include "apps/terminal/progress_bar.h"
#include "apps/terminal/renderer_options.h"
#include "apps/terminal/text_options.h"
#include "apps/verbs.h"
#include "core/file.h"
#include "core/json_fields.h"
#include "core/png.h"
#include "core/text.h"
#include "pipeline/evaluate/evaluate.h"
#include "pipeline/evaluate/picture_sheet.h"
#include "pipeline/evaluate/temporal.h"
#include "pipeline/json_report.h"
#include "pipeline/orbit.h"
#include "pipeline/plan/process_plan.h"
#include "render/back_end.h"

namespace floatstage::apps {
namespace {

using nlohmann::json;

struct EvaluateArguments {
  std::filesystem::path take, json_file, csv_file, sheet, path_file;
  std::vector<std::string> inputs, hold_out, methods = {"nearest", "linear", "floating"};
  std::string frames, proxy, scale = "1/1";
  bool orbit = false, classes = false;
  pipeline::OrbitOptions walk;
  int border = -1, steps = 200;
  bool mattes = false;
  std::filesystem::path truth;
  pipeline::LabelChoice labels;
  RendererFlags renderer;
  HullFlags hull;
  PlanFlags plan;
};

constexpr double kFrameSeconds = 10;  // before a plan has measured it

Result<int> parse_scale(const std::string& words) {
  constexpr int kSmallest = 64;
  int n = 0;
  const char* end = words.data() + words.size();
  if (words.starts_with("1/")) {
    const auto [stop, error] = std::from_chars(words.data() + 2, end, n);
    if (error == std::errc() && stop == end && n >= 1 && n <= kSmallest) return n;
  }
  return fail(ErrorCode::InvalidArgument,
              text("--scale '", words, "' is no scale; write 1/2 for half the size, down to 1/", kSmallest));
}

// What is asked for, without the take.
Result<pipeline::EvaluateOptions> evaluate_options(const EvaluateArguments& given) {
  const Result<recon::HullOptions> hull = hull_options(given.hull);
  if (!hull) return forward(hull);
  pipeline::EvaluateOptions options{.inputs = given.inputs,
                                    .hold_out = given.hold_out,
                                    .methods = given.methods,
                                    .renderer = {},
                                    .proxy = {}};
  options.proxy.hull = *hull;
  if (given.hull.given()) options.proxy.kind = pipeline::Proxy::Kind::Hull;
  if (!given.proxy.empty()) {
    const Result<pipeline::Proxy> proxy = pipeline::parse_proxy(given.proxy, *hull);
    if (!proxy) return forward(proxy);
    options.proxy = *proxy;
  }
  const Result<int> scale = parse_scale(given.scale);
  if (!scale) return forward(scale);
  options.scale = *scale;
  options.border = given.border;
  const Result<render::RendererOptions> renderer = renderer_options(given.renderer);
  if (!renderer) return forward(renderer);
  options.renderer = *renderer;
  options.balance = given.renderer.balance;
  options.classes = given.classes;
  return options;
}

json to_json(const pipeline::TemporalScores& s) {
  return {{"jitter", s.jitter}, {"jitter_p999", s.jitter_p999},
          {"pop", s.pop},       {"set_changes", s.set_changes},
          {"steps", s.steps},   {"points", s.points}};
}

Result<pipeline::CameraPath> path_of(const EvaluateArguments& given, capture::TakeReader& take,
                                     const pipeline::EvaluateOptions& options) {
  if (!given.orbit) return pipeline::load_path(given.path_file);
  Result<pipeline::Instant> instant = pipeline::load_instant(take, options.frames.front(), options.proxy);
  if (!instant) return forward(instant);
  const Result<Mesh> mesh = pipeline::proxy_without(
      take, *instant, -1, std::vector<bool>(take.rig().cameras.size(), true), options.proxy);
  if (!mesh) return forward(mesh);
  pipeline::Subject subject;
  pipeline::add(*mesh, subject);
  pipeline::OrbitOptions walk = given.walk;
  walk.seconds = 1;
  return pipeline::orbit_around(take.rig(), subject, walk).path;
}

Result<void> run_path(const EvaluateArguments& given, capture::TakeReader& take,
                      const pipeline::EvaluateOptions& options) {
  const Result<pipeline::CameraPath> path = path_of(given, take, options);
  if (!path) return forward(path);
  const Result<std::map<std::string, pipeline::TemporalScores>> scores =
      pipeline::evaluate_path(take, options, {*path, given.steps});
  if (!scores) return forward(scores);
  std::printf("%-12s %10s %12s %10s %12s\n", "along", "jitter", "jitter_p999", "pop", "set_changes");
  json j = {{"take", given.take.string()}};
  for (const std::string& m : options.methods) {
    const pipeline::TemporalScores& s = scores->at(m);
    std::printf("%-12s %10.4f %12.3f %10.3f %12d\n", m.c_str(), s.jitter, s.jitter_p999, s.pop,
                s.set_changes);
    j["mean"][m]["temporal"] = to_json(s);
  }
  return given.json_file.empty() ? Result<void>() : pipeline::save_json(j, given.json_file);
}

Result<std::vector<ScoredView>> held_out_rows(const EvaluateArguments& given, capture::TakeReader& take,
                                              const pipeline::EvaluateOptions& options, ProgressBar& bar) {
  const Result<pipeline::Inputs> inputs =
      pipeline::choose_inputs(take.rig(), options.inputs, options.hold_out);
  if (!inputs) return forward(inputs);
  if (!given.sheet.empty())
    if (Result<void> ok = make_folder(given.sheet); !ok) return forward(ok);
  std::vector<ScoredView> rows;
  pipeline::ProgressPart progress(&bar, "views", inputs->held.size() * options.frames.size());
  Result<void> done = pipeline::evaluate_take(take, options, [&](pipeline::HeldOutView view) -> Result<void> {
    progress.advance();
    if (!given.sheet.empty()) {
      const std::string name = text(view.serial, "-", view.frame, ".png");
      if (Result<void> ok = save_png(pipeline::sheet_row(view, options.methods), given.sheet / name); !ok)
        return ok;
    }
    rows.push_back({std::move(view.serial), view.frame, view.has_matte, std::move(view.scores)});
    return {};
  });
  if (!done) return forward(done);
  return rows;
}

Result<void> report(const EvaluateArguments& given, const std::vector<ScoredView>& views) {
  return report_scores(given.take, views, given.methods, {given.json_file, given.csv_file});
}

// The take, what of it is asked for, and what draws it, which has to outlive the drawing.
struct Ready {
  std::unique_ptr<capture::TakeReader> take;
  pipeline::EvaluateOptions options;
  render::OpenBackEnd drawing;
};

Result<Ready> ready(const EvaluateArguments& given) {
  if (given.orbit && !given.path_file.empty())
    return fail(ErrorCode::InvalidArgument, "say where the camera goes: either --orbit or --path FILE");
  Result<pipeline::EvaluateOptions> options = evaluate_options(given);
  if (!options) return forward(options);
  Result<std::unique_ptr<capture::TakeReader>> take = pipeline::open_chosen(given.take, given.labels);
  if (!take) return forward(take);
  Result<std::vector<int>> frames =
      parse_frames(given.frames.empty() ? "0" : given.frames, (*take)->frame_count());
  if (!frames) return forward(frames);
  options->frames = std::move(*frames);
  if (Result<void> ok = suit_cameras(given.renderer, (*take)->rig(), options->renderer); !ok)
    return forward(ok);
  Result<render::OpenBackEnd> drawing = render::open_back_end(options->renderer.back_end);
  if (!drawing) return forward(drawing);
  options->renderer.back_end = drawing->back_end;
  return Ready{std::move(*take), std::move(*options), std::move(*drawing)};
}

bool walks(const EvaluateArguments& given) { return given.orbit || !given.path_file.empty(); }

Result<void> run_evaluate(const EvaluateArguments& given) {
  if (given.mattes)
    return report_mattes({given.take, given.labels, given.truth, given.frames, given.json_file});
  Result<Ready> scene = ready(given);
  if (!scene) return forward(scene);
  ProgressBar bar;
  scene->options.progress = &bar;
  if (walks(given)) return run_path(given, *scene->take, scene->options);
  const Result<std::vector<ScoredView>> rows = held_out_rows(given, *scene->take, scene->options, bar);
  return rows ? report(given, *rows) : forward(rows);
}

Result<pipeline::Plan> make_plan(const EvaluateArguments& given, int chunk) {
  if (given.mattes || walks(given))
    return fail(ErrorCode::InvalidArgument,
                "--plan divides held-out views by frames; --mattes, --orbit and --path are one piece");
  const Result<std::vector<int>> frames =
      frames_of_take(given.take, given.frames.empty() ? "0" : given.frames);
  if (!frames) return forward(frames);
  return pipeline::plan_of_pieces(given.take, "views", pipeline::pieces_of(*frames, chunk), kFrameSeconds);
}

// The last frame of the piece before, which the first of this one is compared with for flicker; -1: none.
int last_before(const pipeline::Plan& plan, const pipeline::PlanItem& item) {
  int last = -1;
  for (const pipeline::PlanItem& piece : plan.items) {
    if (piece.id == item.id) break;
    if (const std::vector<int> frames = piece.frames(); piece.count > 0 && !frames.empty())
      last = frames.back();
  }
  return last;
}

// A piece's rows, or the table of all.
Result<ItemEnd> run_item(const EvaluateArguments& given, const pipeline::Plan& plan,
                         const pipeline::PlanItem& item) {
  ItemEnd end;
  if (item.count > 0) {
    Result<Ready> scene = ready(given);
    if (!scene) return forward(scene);
    ProgressBar bar;
    scene->options.frames = item.frames();
    scene->options.frame_before = last_before(plan, item);
    scene->options.progress = &bar;
    const Result<std::vector<ScoredView>> rows = held_out_rows(given, *scene->take, scene->options, bar);
    if (!rows) return forward(rows);
    const std::string bytes = json_of(*rows).dump();
    if (Result<void> ok = write_file(plan.done(item.id), bytes); !ok) return forward(ok);
    end.bytes = bytes.size();
    return end;
  }
  std::vector<ScoredView> all;
  for (const pipeline::PlanItem& piece : plan.items) {
    if (piece.count == 0) continue;
    const Result<std::string> bytes = read_file(plan.done(piece.id));
    if (!bytes) return forward(bytes);
    const Result<json> rows = parse_json(*bytes, plan.done(piece.id).string());
    if (!rows) return forward(rows);
    Result<std::vector<ScoredView>> views = views_of(*rows);
    if (!views)
      return fail(views.error().code, text(plan.done(piece.id).string(), " ", views.error().message,
                                           "; remove the plan's folder and begin anew"));
    for (ScoredView& view : *views) all.push_back(std::move(view));
  }
  if (Result<void> ok = report(given, all); !ok) return forward(ok);
  return end;
}

Planned planned(const EvaluateArguments& given) {
  return {.folder = plan_beside(given.take, "evaluate"),
          .threads = 0,
          .make = [given](int chunk) { return make_plan(given, chunk); },
          .made_from = [given] { return pipeline::plan_inputs(given.take); },
          .run = [given](const pipeline::Plan& plan,
                         const pipeline::PlanItem& item) { return run_item(given, plan, item); }};
}

}  // namespace

void add_evaluate(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<EvaluateArguments>();
  CLI::App* verb =
      add_verb(app, chosen, "evaluate",
               "Scores: renderers on a processed take, leave-one-out; or its mattes against true ones",
               {"floatstage evaluate take --hold-out cam02,cam05 --frames 0:50:10 --json scores.json",
                "floatstage evaluate take --orbit --methods linear,floating --json steadiness.json"});
  add_take(*verb, options->take);
  add_label_choice(*verb, options->labels);

  add_list(*verb, "--inputs", options->inputs,
           "Cameras to draw from: serials, or every:N for every N-th, on a grid every N-th "
           "of every N-th row (default: all)");
  add_list(*verb, "--hold-out", options->hold_out,
           "Cameras, by serial, each left out in turn (default: those that are no --inputs, of a grid the "
           "ones in the middle between; every one where all are)");
  add_list(*verb, "--methods", options->methods, method_help(), renderer_names());
  add_frames(*verb, options->frames, "0; with --mattes: all");
  verb->add_option("--csv", options->csv_file, "Write the scores as CSV")->type_name("FILE");
  verb->add_option("--sheet", options->sheet,
                   "Write a picture sheet a view to this folder: truth, methods, difference")
      ->type_name("FOLDER");
  verb->add_option(
          "--proxy", options->proxy,
          "What photographs are projected onto: exact or octree (a hull without the held-out camera), "
          "FILE.ply, or plane:Z, metres before the cameras (default: what films are drawn on)")
      ->type_name("WHAT");
  verb->add_option("--scale", options->scale, "Draw and compare at 1/N of the photographs' size")
      ->capture_default_str()
      ->type_name("1/N");
  verb->add_option("--border", options->border,
                   "Pixels along the picture's sides that do not count (default: none; without mattes a "
                   "twelfth of the width)")
      ->check(CLI::NonNegativeNumber)
      ->type_name("PX");
  verb->add_flag("--orbit", options->orbit,
                 "Walk around instead, where the cameras stand, and say how steady the methods are");
  verb->add_option("--path", options->path_file, "The same along a camera path")->type_name("FILE");
  verb->add_option("--steps", options->steps, "Pictures of that walk")->capture_default_str();
  verb->add_flag("--classes", options->classes,
                 "Say of how many pixels plain blending makes blurred ones or ghosts: predicted from "
                 "--uncertainty, and as the flow measures them");
  verb->add_flag("--mattes", options->mattes,
                 "Score the take's mattes against true ones instead of rendered views")
      ->group(kGroupMattes);
  verb->add_option("--truth", options->truth,
                   "Folder of true mattes, <serial>/<frame>.png (default: the take's truth/mattes)")
      ->type_name("FOLDER")
      ->group(kGroupMattes);
  add_hull_flags(*verb, options->hull);
  add_orbit_flags(*verb, options->walk, verb->get_option("--orbit"));
  add_renderer_flags(*verb, options->renderer);
  add_json(*verb, options->json_file);
  add_planned_run(*verb, chosen, options, run_evaluate, planned);
}

}  // namespace floatstage::apps
