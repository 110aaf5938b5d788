#include <cmath>
#include <iomanip>

#include "apps/calibrate/calibrate_verbs.h"
#include "apps/calibrate/scratch_folder.h"
#include "apps/terminal/flags.h"
#include "apps/terminal/interrupt.h"
#include "apps/terminal/progress_bar.h"
#include "calib/calibrate.h"
#include "calib/uncertainty/picture_advice.h"
#include "core/log.h"
#include "core/text.h"
#include "pipeline/calibrate/calibration_outcome.h"
#include "pipeline/calibrate/report.h"
#include "pipeline/calibrate/scene.h"
#include "pipeline/calibrate/scene_points.h"
#include "pipeline/calibrate/session.h"
#include "pipeline/calibrate/session_observations.h"
#include "pipeline/progress.h"

namespace floatstage::apps {
namespace {

struct SessionArguments {
  std::filesystem::path session, out, report, json, cache, observations, from, workspace;
  int threads = 0;
  bool keep_failed = false;
};

// The session's file, and the rig of before where one is given.
Result<pipeline::Session> open_session(const SessionArguments& given) {
  Result<pipeline::Session> session = pipeline::load_session(given.session);
  if (!session) return forward(session);
  session->options.threads = given.threads;
  if (given.from.empty()) return session;
  // A target measures the lenses again; the scene alone does not.
  const bool keep =
      session->markerless || (session->known && session->known->intrinsics == calib::Prior::Fixed);
  session->known = pipeline::SessionKnown{.format = "rig",
                                          .file = given.from,
                                          .intrinsics = keep ? calib::Prior::Fixed : calib::Prior::Start,
                                          .poses = calib::Prior::Start};
  return session;
}

// What the session's pictures show: the target, and without one what COLMAP finds in the scene.
Result<pipeline::SessionObservations> observe(const pipeline::Session& session,
                                              const SessionArguments& given) {
  ProgressBar bar;
  Result<pipeline::SessionObservations> collected =
      pipeline::collect(session, given.cache, given.threads, &bar);
  if (!collected) return collected;
  if (session.markerless) {
    const ScratchFolder workspace(given.workspace);
    if (!workspace.ready()) return forward(workspace.ready());
    if (Result<void> ok = pipeline::add_scene(session, workspace.folder(), given.threads, &bar, *collected);
        !ok) {
      if (ok.error().code == ErrorCode::Cancelled) return pipeline::cancelled_unwritten();
      return fail(ok.error().code,
                  text(given.session.string(), ": ", ok.error().message,
                       workspace.stays() ? "" : "; --workspace FOLDER keeps what COLMAP wrote"));
    }
  }
  if (interrupted()) return pipeline::cancelled_unwritten();
  for (const std::string& sentence : collected->detection) log::info(sentence);
  if (!given.observations.empty())
    if (Result<void> ok = calib::save_observations(collected->observations, given.observations); !ok)
      return forward(ok);
  return collected;
}

// How the solution compares with the rig that is known, as remarks and checks.
Result<void> compare_with_known(const pipeline::Session& session, const Rig& solved,
                                pipeline::ReportContext& context, std::vector<pipeline::BarCheck>& checks) {
  const Result<Rig> known = pipeline::load_known(*session.known);
  if (!known) return forward(known);
  for (std::string& sentence : pipeline::compare_to_known(*session.known, *known, solved))
    context.remarks.push_back(std::move(sentence));
  if (const auto compared = pipeline::compare_poses(*session.known, *known, solved)) {
    pipeline::BarCheck check{.what = "known_center_percent", .camera = "", .value = {}, .required = true};
    if (const Result<calib::RigAgreement>& a = *compared) {
      context.remarks.push_back(
          text("camera centres are ", std::fixed, std::setprecision(3), a->rms_percent,
               " % (RMS) and at worst ", a->worst_percent, " % (camera '", a->worst,
               "') of the rig's radius from the known ones after a similarity, which enlarges by ", a->scale,
               "; rotations at worst: ", to_words(a->worst_turn_degrees, 3, "°")));
      check.camera = a->worst;
      check.value = {a->worst_percent, a->cameras};
    } else {
      context.remarks.push_back(text("not compared with the known poses: ", compared->error().message));
      check.value = Measured::not_measured(compared->error().message);
    }
    check.bar = session.bars.known_center_percent.value_or(0);
    if (session.bars.known_center_percent) checks.push_back(std::move(check));
  }
  if (session.points.empty()) return {};
  const Result<pipeline::ScenePoints> measured = pipeline::measure_points(session.points, *known);
  if (!measured)
    return fail(measured.error().code, text(session.known->file.string(), ": ", measured.error().message));
  context.remarks.push_back(pipeline::describe(*measured, *known, "known"));
  return {};
}

Result<void> run_session(const SessionArguments& given) {
  if (given.session.empty())
    return fail(ErrorCode::InvalidArgument,
                "calibrate: give a session (a .toml file; docs/calibrating.md), or 'target' to print one");
  const Result<pipeline::Session> session = open_session(given);
  if (!session) return forward(session);
  const Result<pipeline::SessionObservations> collected = observe(*session, given);
  if (!collected) return forward(collected);
  const Result<calib::Calibration> solved = calib::calibrate(collected->observations, session->options);
  if (!solved) return fail(solved.error().code, text(given.session.string(), ": ", solved.error().message));
  if (interrupted()) return pipeline::cancelled_unwritten();
  pipeline::ReportContext context{given.session.stem().string(), collected->detection, collected->remarks,
                                  collected->seconds};
  if (session->volume) context.volume = calib::box_volume(session->volume->low, session->volume->high);
  const calib::WorkingVolume volume = session->volume ? context.volume : calib::hull_of_targets(*solved);
  for (const calib::PictureAdvice& advice :
       calib::pictures_to_add(*solved, collected->observations, volume, session->bars.projection_sigma_px))
    context.remarks.push_back(advice.sentence);
  std::vector<pipeline::BarCheck> checks;
  if (session->known)
    if (Result<void> ok = compare_with_known(*session, solved->rig, context, checks); !ok) return ok;
  if (!session->points.empty() && !solved->rig.cameras.empty()) {
    const Result<pipeline::ScenePoints> measured = pipeline::measure_points(session->points, solved->rig);
    context.remarks.push_back(measured ? pipeline::describe(*measured, solved->rig, "solved")
                                       : measured.error().message);
    checks.push_back({.what = "points_px",
                      .camera = "",
                      .value = measured ? measured->rms_px : Measured::not_measured(measured.error().message),
                      .bar = session->bars.points_px,
                      .required = true});
  }
  return pipeline::write_outcome(
      *solved, session->bars, checks, context,
      {given.session.string(), given.out, given.report, given.json, given.keep_failed, collected->carried});
}

}  // namespace

void add_calibrate_session(CLI::App& calibrate, Chosen& chosen) {
  auto options = std::make_shared<SessionArguments>();
  calibrate.add_option(
      "session", options->session,
      "The session (.toml): which pictures are of which camera, what they show, what is known");
  add_out(calibrate, options->out, "The rig.json to write when the calibration passes");
  calibrate.add_option("--report", options->report, "Folder for calibration.html and calibration.json")
      ->type_name("FOLDER");
  calibrate
      .add_option(
          "--from", options->from,
          "A rig.json of before: solved again from there, in its world, saying which camera has moved")
      ->type_name("FILE");
  calibrate.add_option("--cache", options->cache, "Folder that keeps what was detected, for the next time")
      ->type_name("FOLDER");
  calibrate.add_option("--observations", options->observations, "Write what was detected to this file")
      ->type_name("FILE");
  calibrate.add_flag("--keep-failed", options->keep_failed,
                     "Write --out even when the calibration does not pass");
  add_threads(calibrate, options->threads);
  add_json(calibrate, options->json);
  calibrate
      .add_option("--workspace", options->workspace,
                  "New folder for what COLMAP writes, kept (markerless sessions)")
      ->type_name("FOLDER")
      ->group(kGroupTuning);
  calibrate.callback([options, &calibrate, &chosen] {
    if (calibrate.get_subcommands().empty()) chosen.run = [options] { return run_session(*options); };
  });
}

}  // namespace floatstage::apps
