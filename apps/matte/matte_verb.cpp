#include <cstdio>
#include <memory>

#include <nlohmann/json.hpp>

#include "apps/matte/label_words.h"
#include "apps/matte/matte_clip.h"
#include "apps/matte/matte_doubts.h"
#include "apps/matte/matte_verbs.h"
#include "apps/plan/planned.h"
#include "apps/terminal/flags.h"
#include "apps/terminal/progress_bar.h"
#include "apps/terminal/verb.h"
#include "core/log.h"
#include "core/text.h"
#include "pipeline/json_report.h"
#include "pipeline/matte/export_layers.h"
#include "pipeline/matte/label_take.h"
#include "pipeline/matte/matte_take.h"
#include "pipeline/plan/process_plan.h"

namespace floatstage::apps {
namespace {

using nlohmann::json;

constexpr std::size_t kWorstShown = 5;

struct MatteArguments {
  pipeline::MatteTakeOptions matte;
  std::string how, frames;
  std::filesystem::path json_file;
  pipeline::ExportOptions layers;
  ClipFlags clip;
  PlanFlags plan;
  std::vector<std::string> found = {};  ///< Plan::remarks, of the run that reports for its items
};

json to_json(const std::optional<pipeline::ConsistentView>& view) {
  if (!view) return {};
  return {{"subject", view->subject},
          {"sure", view->sure},
          {"border", view->border},
          {"missing", view->missing},
          {"surplus", view->surplus}};
}

json to_json(const pipeline::MatteReport& report) {
  json per_camera = json::object(), worst = json::array();
  for (const pipeline::CameraMattes& c : report.cameras)
    per_camera[c.serial] = {{"key", c.key},
                            {"method", c.method},
                            {"made", c.made},
                            {"kept", c.kept},
                            {"others", c.others},
                            {"gaps", c.gaps},
                            {"keyframes", c.keyframes},
                            {"clicks", c.clicks},
                            {"flicker", c.flicker},
                            {"hull_agreement", c.hull_agreement ? json(*c.hull_agreement) : json()},
                            {"consistent", to_json(c.consistent)},
                            {"failures", c.failures}};
  for (const recon::SilhouetteAgreement& a : report.worst)
    worst.push_back({{"camera", a.serial}, {"frame", a.frame}, {"iou", a.iou}, {"surplus", a.surplus}});
  return {{"seconds_per_frame", report.seconds_per_frame},
          {"seconds", report.seconds},
          {"per_camera", per_camera},
          {"remarks", report.remarks},
          {"distrusted", report.distrusted},
          {"doubts", doubts_json(report.doubts)},
          {"healed", healed_json(report.healed)},
          {"camera_doubts", report.camera_doubts},
          {"worst", worst}};
}

// What is asked for of a take.
Result<pipeline::MatteTakeOptions> options_of(const MatteArguments& given) {
  pipeline::MatteTakeOptions options = given.matte;
  if (!given.how.empty()) options.how = given.how;
  if (!given.frames.empty()) {
    Result<std::vector<int>> frames = frames_of_take(options.take, given.frames);
    if (!frames) return forward(frames);
    options.frames = std::move(*frames);
  }
  return options;
}

// The mattes divided among labels, where somebody asked for it, now or before. Returns what is in doubt.
Result<std::vector<pipeline::MatteDoubt>> matte_labels(const MatteArguments& given, ProgressBar& bar) {
  pipeline::LabelTakeOptions options{
      .threads = given.matte.threads, .redo = given.matte.redo, .progress = &bar};
  if (!given.clip.labels.empty() || !given.clip.clicks.empty()) {
    const Result<std::vector<NamedPath>> masks = named_paths(given.clip.labels);
    if (!masks) return forward(masks);
    Result<std::vector<pipeline::LabelClick>> clicks = label_clicks(given.clip.clicks);
    if (!clicks) return forward(clicks);
    options.said = {{}, std::move(*clicks)};
    for (const NamedPath& m : *masks) options.said->masks.push_back({m.name, m.path});
  }
  Result<pipeline::LabelTakeReport> report = pipeline::label_take(given.matte.take, options);
  if (!report) return forward(report);
  if (report->labels.empty()) return report->doubts;
  std::string names;
  for (const std::string& label : report->labels) names += (names.empty() ? "" : ", ") + label;
  std::printf("%s: from %d photographs that were given; %d mattes made, %d kept", names.c_str(),
              report->given, report->made, report->kept);
  if (report->others > 0) std::printf("; %d of unknown origin, used as masks", report->others);
  std::printf("; %.1f s\n", report->seconds);
  for (const pipeline::MatteDoubt& d : report->doubts)
    std::fprintf(stderr, "floatstage: %s\n", sentence(d).c_str());
  return std::move(report->doubts);
}

Result<void> run_matte(const MatteArguments& given) {
  Result<bool> clip = is_clip(given.matte.take, given.matte.guide, given.clip);
  if (!clip) return forward(clip);
  if (*clip) return matte_clip(given.matte.take, given.matte.guide, given.clip, given.json_file);
  Result<pipeline::MatteTakeOptions> read = options_of(given);
  if (!read) return forward(read);
  pipeline::MatteTakeOptions options = std::move(*read);
  ProgressBar bar;
  options.progress = &bar;
  options.heal = true;
  Result<pipeline::MatteReport> report = pipeline::matte_take(options);
  if (!report) return forward(report);
  report->remarks.insert(report->remarks.begin(), given.found.begin(), given.found.end());
  for (const std::string& doubt : report->camera_doubts)
    std::fprintf(stderr, "floatstage: %s\n", doubt.c_str());
  std::size_t failures = 0;
  for (const pipeline::CameraMattes& c : report->cameras) {
    std::printf("%s: %s by %s; %d made, %d kept, %d gaps", c.serial.c_str(), c.method.c_str(), c.key.c_str(),
                c.made, c.kept, c.gaps);
    if (c.others > 0) std::printf("; %d of unknown origin, used as they are", c.others);
    if (c.hull_agreement) std::printf("; agrees %.3f with the others' hull", *c.hull_agreement);
    std::printf("\n");
    for (const std::string& f : c.failures) std::fprintf(stderr, "floatstage: %s\n", f.c_str());
    failures += c.failures.size();
  }
  for (const std::string& r : report->remarks) log::warning(r);
  for (const pipeline::MatteDoubt& d : report->doubts)
    std::fprintf(stderr, "floatstage: %s\n", sentence(d).c_str());
  for (const pipeline::HealedCamera& healed : report->healed)
    std::fprintf(stderr, "floatstage: %s\n", sentence(healed).c_str());
  for (std::size_t i = 0; i < std::min(kWorstShown, report->worst.size()); ++i)
    std::printf("worst: %s frame %d, IoU %.3f, %.1f %% outside\n", report->worst[i].serial.c_str(),
                report->worst[i].frame, report->worst[i].iou, 100 * report->worst[i].surplus);
  if (report->made > 0)
    std::printf("%d mattes in %.1f s, %.3f s each\n", report->made, report->seconds,
                report->seconds_per_frame);
  else
    std::printf("no matte had to be made\n");
  Result<std::vector<pipeline::MatteDoubt>> labels = matte_labels(given, bar);
  if (!labels) return forward(labels);
  report->doubts.insert(report->doubts.end(), labels->begin(), labels->end());
  if (!given.layers.out.empty()) {
    pipeline::ExportOptions layers = given.layers;
    layers.take = options.take;
    layers.cameras = options.cameras;
    layers.frames = options.frames;
    layers.threads = options.threads;
    layers.progress = &bar;
    Result<int> written = pipeline::export_layers(layers);
    if (!written) return forward(written);
    std::printf("%s: %d pictures with straight alpha\n", layers.out.c_str(), *written);
  }
  if (!given.json_file.empty())
    if (Result<void> ok = pipeline::save_json(to_json(*report), given.json_file); !ok) return ok;
  if (failures)
    return fail(ErrorCode::BadData,
                text(failures, " photographs could not be matted; the mattes of the others are there"));
  return check_trusted(options.take, report->doubts);
}

// The verb's work by items; what it says, it says of all when they are done.
Result<ItemEnd> run_item(const MatteArguments& given, const pipeline::Plan& plan,
                         const pipeline::PlanItem& item) {
  Result<pipeline::MatteTakeOptions> options = options_of(given);
  if (!options) return forward(options);
  ProgressBar bar;
  options->progress = &bar;
  const Result<std::uint64_t> bytes = pipeline::run_matte_item(plan, item, *options);
  if (!bytes) return forward(bytes);
  if (&item != &plan.items.back()) return ItemEnd{*bytes, {}};
  MatteArguments rest = given;
  rest.matte.redo = false;
  rest.found = plan.remarks;
  return end_of(run_matte(rest));
}

Result<pipeline::Plan> make_plan(const MatteArguments& given, int chunk) {
  Result<bool> clip = is_clip(given.matte.take, given.matte.guide, given.clip);
  if (!clip) return forward(clip);
  if (*clip)
    return fail(ErrorCode::InvalidArgument,
                "--plan divides a take's cameras; a clip is one piece, whose frames need one another");
  const Result<pipeline::MatteTakeOptions> options = options_of(given);
  if (!options) return forward(options);
  return pipeline::plan_mattes(*options, chunk);
}

Planned planned(const MatteArguments& given) {
  return {.folder = plan_beside(given.matte.take, "matte"),
          .threads = given.matte.threads,
          .make = [given](int chunk) { return make_plan(given, chunk); },
          .made_from = [given] { return pipeline::plan_inputs(given.matte.take); },
          .run = [given](const pipeline::Plan& plan,
                         const pipeline::PlanItem& item) { return run_item(given, plan, item); }};
}

}  // namespace

void add_matte(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<MatteArguments>();
  CLI::App* verb = add_verb(
      app, chosen, "matte",
      "Mattes of all cameras of a take, refined and checked against one another; resumable. Of a video or a "
      "folder of pictures: mattes of all frames from masks of a few",
      {"floatstage matte take --matte luminance:30 --frames 12 --json mattes.json",
       "floatstage matte clip.mp4 --label woman=woman.png --label-click woman@40:310,200 -o mattes"});
  add_take(*verb, options->matte.take,
           "The take's folder; its mattes/edits.json is replayed. Or a video, or a folder of pictures");
  add_matte_how(*verb, options->how, kUsualMattes);
  add_guide(*verb, options->matte.guide);
  add_clip_flags(*verb, options->clip);
  add_frames(*verb, options->frames, "all");
  add_cameras(*verb, options->matte.cameras);
  add_added(*verb, options->matte.hide_added);
  add_redo(*verb, options->matte.redo);
  verb->add_option("--export", options->layers.out,
                   "Write the subject with straight alpha to this folder: <serial>/<frame>; of labels, each "
                   "one's opacity in the EXR, or PNGs in <serial>/<label>")
      ->type_name("FOLDER");
  verb->add_option("--export-format", options->layers.format,
                   "8 or 16 bits RGBA in sRGB, or half floats in linear light")
      ->capture_default_str()
      ->check(one_of({"png8", "png16", "exr"}));
  add_threads(*verb, options->matte.threads);
  add_json(*verb, options->json_file);
  verb->add_option("--hull-frames", options->matte.hull_frames,
                   "Check silhouettes against the others' hull at so many instants; 0: not at all")
      ->capture_default_str()
      ->check(CLI::NonNegativeNumber)
      ->group(kGroupTuning);
  add_planned_run(*verb, chosen, options, run_matte, planned);
}

}  // namespace floatstage::apps
