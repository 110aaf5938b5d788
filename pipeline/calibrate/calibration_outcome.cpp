#include "pipeline/calibrate/calibration_outcome.h"

#include <algorithm>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "core/rig_io.h"
#include "core/text.h"
#include "pipeline/json_report.h"

namespace floatstage::pipeline {

Result<void> write_outcome(const calib::Calibration& solved, const CalibrationBars& bars,
                           const std::vector<BarCheck>& checks, const ReportContext& context,
                           const OutcomeOptions& given) {
  const calib::WorkingVolume volume =
      context.volume.points.empty() ? calib::hull_of_targets(solved) : context.volume;
  Verdict verdict = judge(solved, bars, volume);
  for (const BarCheck& check : checks) add_check(verdict, solved, check);
  for (const calib::CameraQuality& q : solved.cameras)
    std::printf("%s: %s, P95 %s, held out %s, %d points of %d views, %d left out\n", q.serial.c_str(),
                short_words(q.rms_px, 3, " px").c_str(), short_words(q.p95_px, 3, " px").c_str(),
                short_words(q.holdout_px, 3, " px").c_str(), q.points, q.views, q.outliers);
  if (solved.scale.count > 0)
    std::printf("%d known lengths: RMS %.3f mm, bias %.3f mm\n", solved.scale.count, solved.scale.rms_mm,
                solved.scale.bias_mm);
  for (const std::string& remark : context.remarks) std::printf("%s\n", remark.c_str());
  for (const std::string& remark : solved.remarks) std::printf("%s\n", remark.c_str());
  if (!volume.points.empty()) std::printf("projection sigmas over %s\n", volume.how.c_str());
  std::printf("%s\n", describe(solved, verdict).c_str());

  if (!given.report.empty()) {
    if (Result<void> ok = save_report(solved, verdict, context, given.report); !ok) return ok;
  }
  if (!given.json.empty()) {
    if (Result<void> ok = save_json(report_json(solved, verdict, context), given.json); !ok) return ok;
  }
  const bool write = !given.out.empty() && !solved.rig.cameras.empty() && (verdict.pass || given.keep_failed);
  if (write) {
    Rig rig = solved.rig;
    std::erase_if(rig.cameras, [&](const RigCamera& c) {
      return std::count(given.left_out.begin(), given.left_out.end(), c.serial) > 0;
    });
    if (Result<void> ok = save_rig(rig, given.out); !ok) return ok;
  }
  if (!verdict.pass)
    return fail(ErrorCode::BadData,
                text(given.name, ": this calibration does not pass",
                     write || given.out.empty() ? "" : text("; ", given.out.string(), " was not written")));
  return {};
}

}  // namespace floatstage::pipeline
