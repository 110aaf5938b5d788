#include <cstdio>
#include <nlohmann/json.hpp>

#include "apps/calibrate/collect.h"
#include "apps/calibrate/report.h"
#include "apps/calibrate/session.h"
#include "apps/calibrate_verbs.h"
#include "apps/json_report.h"
#include "calib/calibrate.h"
#include "core/log.h"
#include "core/rig_io.h"
#include "core/text.h"

namespace floatstage {
namespace {

struct Options {
  std::filesystem::path session, out, report, json, cache, observations;
  int threads = 0;
  bool keep_failed = false;
};

Result<void> run(const Options& given) {
  if (given.session.empty()) return fail(ErrorCode::InvalidArgument, "calibrate: give a session (a .toml file; docs/calibrating.md), or 'target' to print one");
  Result<Session> session = load_session(given.session);
  if (!session) return forward(session);
  session->options.threads = given.threads;
  Result<Collected> collected = collect(*session, given.cache, given.threads);
  if (!collected) return forward(collected);
  for (const std::string& sentence : collected->detection) log::info(sentence);
  if (!given.observations.empty()) {
    if (Result<void> ok = save_observations(collected->observations, given.observations); !ok) return ok;
  }
  const Result<Calibration> solved = calibrate(collected->observations, session->options);
  if (!solved) return fail(solved.error().code, text(given.session.string(), ": ", solved.error().message));

  ReportContext context{given.session.stem().string(), collected->detection, collected->remarks, collected->seconds};
  if (session->known) {
    const Result<Rig> known = load_known(*session->known);
    if (!known) return forward(known);
    for (std::string& sentence : compare_to_known(*session->known, *known, solved->rig)) context.remarks.push_back(std::move(sentence));
  }
  const Verdict verdict = judge(*solved, session->bars);
  for (const CameraQuality& q : solved->cameras)
    std::printf("%s: %.3f px, P95 %.3f px, held out %.3f px, %d points of %d views, %d left out\n", q.serial.c_str(), q.rms_px, q.p95_px, q.holdout_px, q.points, q.views, q.outliers);
  if (solved->scale.count > 0)
    std::printf("%d known lengths: RMS %.3f mm, bias %.3f mm\n", solved->scale.count, solved->scale.rms_mm, solved->scale.bias_mm);
  for (const std::string& remark : context.remarks) std::printf("%s\n", remark.c_str());
  for (const std::string& remark : solved->remarks) std::printf("%s\n", remark.c_str());
  std::printf("%s\n", describe(*solved, verdict).c_str());

  if (!given.report.empty()) {
    if (Result<void> ok = save_report(*solved, verdict, context, given.report); !ok) return ok;
  }
  if (!given.json.empty()) {
    if (Result<void> ok = save_json(report_json(*solved, verdict, context), given.json); !ok) return ok;
  }
  const bool write = !given.out.empty() && !solved->rig.cameras.empty() && (verdict.pass || given.keep_failed);
  if (write) {
    if (Result<void> ok = save_rig(solved->rig, given.out); !ok) return ok;
  }
  if (!verdict.pass)
    return fail(ErrorCode::BadData, text(given.session.string(), ": this calibration does not pass", write || given.out.empty() ? "" : text("; ", given.out.string(), " was not written")));
  return {};
}

}  // namespace

void add_calibrate_session(CLI::App& calibrate, Chosen& chosen) {
  auto options = std::make_shared<Options>();
  calibrate.add_option("session", options->session, "The session (.toml): which pictures are of which camera, what they show, what is known");
  calibrate.add_option("--out", options->out, "The rig.json to write when the calibration passes");
  calibrate.add_option("--report", options->report, "Folder for calibration.html and calibration.json");
  calibrate.add_option("--json", options->json, "Write the report as JSON to this file");
  calibrate.add_option("--cache", options->cache, "Folder that keeps what was detected, for the next time");
  calibrate.add_option("--observations", options->observations, "Write what was detected to this file");
  calibrate.add_option("--threads", options->threads, "Threads; 0: one per core")->capture_default_str()->check(CLI::NonNegativeNumber);
  calibrate.add_flag("--keep-failed", options->keep_failed, "Write --out even when the calibration does not pass");
  calibrate.callback([options, &calibrate, &chosen] {
    if (calibrate.get_subcommands().empty()) chosen.run = [options] { return run(*options); };
  });
}

}  // namespace floatstage
