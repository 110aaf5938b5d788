#include <cstdio>

#include <nlohmann/json.hpp>

#include "apps/matte/matte_doubts.h"
#include "apps/plan/planned.h"
#include "apps/terminal/flags.h"
#include "apps/terminal/hull_flags.h"
#include "apps/terminal/label_flags.h"
#include "apps/terminal/progress_bar.h"
#include "apps/verbs.h"
#include "core/log.h"
#include "core/take_layout.h"
#include "core/text.h"
#include "pipeline/json_report.h"
#include "pipeline/plan/process_plan.h"
#include "pipeline/process/process.h"

namespace floatstage::apps {
namespace {

struct ProcessArguments {
  pipeline::ProcessOptions process;
  std::string how, frames;
  std::filesystem::path json_file;
  HullFlags hull;
  PlanFlags plan;
  std::vector<std::string> found = {};  ///< Plan::remarks, of the run that reports for its items
};

nlohmann::json to_json(const pipeline::StageReport& stage) {
  return {{"made", stage.made},
          {"kept", stage.kept},
          {"others", stage.others},
          {"gaps", stage.gaps},
          {"failures", stage.failures}};
}

nlohmann::json to_json(const std::vector<pipeline::SilhouetteFault>& faults) {
  nlohmann::json j = nlohmann::json::array();
  for (const pipeline::SilhouetteFault& fault : faults)
    j.push_back({{"camera", fault.serial},
                 {"frames", fault.frames},
                 {"worst_frame", fault.worst},
                 {"lost", fault.lost},
                 {"gained", fault.gained},
                 {"picture", fault.picture.string()}});
  return j;
}

nlohmann::json to_json(const std::optional<pipeline::CleanupCost>& cost) {
  if (!cost) return nullptr;
  return {{"meshes", cost->meshes},
          {"triangles", cost->most_triangles},
          {"iou_loss", cost->iou_loss},
          {"camera", cost->serial},
          {"worst_frame", cost->frame}};
}

nlohmann::json to_json(const std::optional<pipeline::FieldReport>& fields) {
  if (!fields) return nullptr;
  return {{"made", fields->made}, {"kept", fields->kept}, {"failures", fields->failures}};
}

nlohmann::json to_json(const std::filesystem::path& take, const pipeline::ProcessReport& report) {
  return {{"take", take.string()},
          {"frames", report.frames},
          {"cameras", report.cameras},
          {"empty_frames", report.empty_frames},
          {"mattes", to_json(report.mattes)},
          {"meshes", to_json(report.meshes)},
          {"fields", to_json(report.fields)},
          {"remarks", report.remarks},
          {"distrusted", report.distrusted},
          {"doubts", doubts_json(report.doubts)},
          {"healed", healed_json(report.healed)},
          {"silhouettes", to_json(report.faults)},
          {"camera_doubts", report.camera_doubts},
          {"poses", report.pose_doubts},
          {"contradictory_frames", report.contradictory_frames},
          {"cut_frames", report.cut_frames},
          {"poor_frames", report.poor_frames},
          {"cleanup", to_json(report.cleanup)},
          {"seconds", report.seconds}};
}

// What was made, and on the error's stream what is wrong with it.
void say(const std::filesystem::path& take, const pipeline::ProcessReport& report) {
  for (const std::string& r : report.remarks) log::warning(r);
  for (const std::string& doubt : report.camera_doubts)
    std::fprintf(stderr, "floatstage: %s\n", doubt.c_str());
  for (const pipeline::StageReport* stage : {&report.mattes, &report.meshes})
    for (const std::string& f : stage->failures) std::fprintf(stderr, "floatstage: %s\n", f.c_str());
  for (const pipeline::MatteDoubt& d : report.doubts)
    std::fprintf(stderr, "floatstage: %s\n", sentence(d).c_str());
  for (const pipeline::HealedCamera& healed : report.healed)
    std::fprintf(stderr, "floatstage: %s\n", sentence(healed).c_str());
  for (const pipeline::SilhouetteFault& fault : report.faults)
    std::fprintf(stderr, "floatstage: %s\n", sentence(fault).c_str());
  for (const std::string& doubt : report.pose_doubts) std::fprintf(stderr, "floatstage: %s\n", doubt.c_str());
  if (report.poor_frames > 0 && report.doubts.empty())
    std::fprintf(
        stderr,
        "floatstage: %d hulls explain less than 90 %% of half of the silhouettes: some mattes lack what "
        "the others see, or the calibration is off (silhouette_iou in meshes/hull.json)\n",
        report.poor_frames);
  if (report.cut_frames > 0)
    std::fprintf(
        stderr,
        "floatstage: %d hulls are cut where the subject goes on beyond what enough cameras see; give "
        "--volume to search more\n",
        report.cut_frames);
  std::printf(
      "%s: %d frames of %d cameras; mattes %d made, %d kept, %d gaps; meshes %d made, %d kept; %.1f s\n",
      take.c_str(), report.frames, report.cameras, report.mattes.made, report.mattes.kept, report.mattes.gaps,
      report.meshes.made, report.meshes.kept, report.seconds);
  if (report.fields) {
    for (const std::string& f : report.fields->failures) std::fprintf(stderr, "floatstage: %s\n", f.c_str());
    std::printf("fields of %d photographs made, of %d kept\n", report.fields->made, report.fields->kept);
  }
  if (report.cleanup) std::printf("%s\n", sentence(*report.cleanup).c_str());
  if (report.mattes.others + report.meshes.others > 0)
    std::printf("%d mattes and %d meshes are of unknown origin: used as they are\n", report.mattes.others,
                report.meshes.others);
}

Result<pipeline::ProcessOptions> options_of(const ProcessArguments& given) {
  pipeline::ProcessOptions options = given.process;
  if (!given.how.empty()) options.matte = given.how;
  if (!given.frames.empty()) {
    Result<std::vector<int>> frames = frames_of_take(options.take, given.frames);
    if (!frames) return forward(frames);
    options.frames = std::move(*frames);
  }
  Result<recon::HullOptions> hull = pipeline::hull_options(given.hull);
  if (!hull) return forward(hull);
  if (given.hull.given()) options.hull = *hull;
  return options;
}

Result<void> run_process(const ProcessArguments& given) {
  Result<pipeline::ProcessOptions> read = options_of(given);
  if (!read) return forward(read);
  pipeline::ProcessOptions options = std::move(*read);
  ProgressBar bar;
  options.progress = &bar;
  Result<pipeline::ProcessReport> report = pipeline::process_take(options);
  if (!report) return forward(report);
  report->remarks.insert(report->remarks.begin(), given.found.begin(), given.found.end());

  const std::size_t failures = report->mattes.failures.size() + report->meshes.failures.size() +
                               (report->fields ? report->fields->failures.size() : 0);
  say(options.take, *report);
  if (!given.json_file.empty())
    if (Result<void> ok = pipeline::save_json(to_json(options.take, *report), given.json_file); !ok)
      return ok;
  if (failures > 0)
    return fail(ErrorCode::BadData,
                text(failures,
                     " of the take's mattes, meshes or fields could not be made; the others are "
                     "there"));
  if (report->empty_frames == report->frames)
    return fail(ErrorCode::BadData,
                text(options.take.string(), ": no frame shows a subject in every silhouette; look at ",
                     TakeLayout(options.take).mattes().string(), " and try another --matte with --redo"));
  if (Result<void> ok = check_trusted(options.take, report->doubts); !ok) return ok;
  if (report->contradictory_frames > 0)
    return fail(ErrorCode::BadData, text(report->contradictory_frames,
                                         " hulls are not to be trusted: their silhouettes contradict one "
                                         "another (the cameras above); look at "
                                         "the mattes and the calibration"));
  return {};
}

// The verb's work by items; what it says, it says of all when they are done.
Result<ItemEnd> run_item(const ProcessArguments& given, const pipeline::Plan& plan,
                         const pipeline::PlanItem& item) {
  Result<pipeline::ProcessOptions> options = options_of(given);
  if (!options) return forward(options);
  ProgressBar bar;
  options->progress = &bar;
  const Result<std::uint64_t> bytes = pipeline::run_process_item(plan, item, *options);
  if (!bytes) return forward(bytes);
  if (&item != &plan.items.back()) return ItemEnd{*bytes, {}};
  ProcessArguments rest = given;
  rest.process.redo = false;
  rest.process.gathered = true;
  rest.found = plan.remarks;
  return end_of(run_process(rest));
}

Planned planned(const ProcessArguments& given) {
  return {.folder = plan_beside(given.process.take, "process"),
          .threads = given.process.threads,
          .make = [given](int chunk) -> Result<pipeline::Plan> {
            const Result<pipeline::ProcessOptions> options = options_of(given);
            if (!options) return forward(options);
            return pipeline::plan_process(*options, chunk);
          },
          .made_from = [given] { return pipeline::plan_inputs(given.process.take); },
          .run = [given](const pipeline::Plan& plan,
                         const pipeline::PlanItem& item) { return run_item(given, plan, item); }};
}

}  // namespace

void add_process(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<ProcessArguments>();
  CLI::App* verb = add_verb(app, chosen, "process",
                            "Every offline stage on a take: mattes, then meshes; does only what is missing",
                            {"floatstage process take --matte chroma --frames 12",
                             "floatstage process take --votes strict --redo -j 4"});
  add_take(*verb, options->process.take);
  add_matte_how(*verb, options->how, kUsualMattes);
  add_guide(*verb, options->process.guide);
  add_frames(*verb, options->frames, "all");
  add_cameras(*verb, options->process.cameras, "Only the mattes of these cameras: serials");
  add_label_choice(*verb, options->process.labels);
  add_added(*verb, options->process.hide_added);
  add_redo(*verb, options->process.redo);
  add_hull_flags(*verb, options->hull);
  verb->add_flag("--fields", options->process.fields,
                 "Also estimate the flow between neighbouring photographs, for --method floating-static");
  add_threads(*verb, options->process.threads);
  add_json(*verb, options->json_file);
  add_planned_run(*verb, chosen, options, run_process, planned);
}

}  // namespace floatstage::apps
