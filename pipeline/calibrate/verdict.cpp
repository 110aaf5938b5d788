#include "pipeline/calibrate/verdict.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/text.h"

namespace floatstage::pipeline {
namespace {

void sum_up(Verdict& v, const calib::Calibration& c) {
  v.pass =
      std::any_of(v.checks.begin(), v.checks.end(), [](const BarCheck& b) { return b.value.count() > 0; }) &&
      c.failures.empty() &&
      std::all_of(v.checks.begin(), v.checks.end(), [](const BarCheck& b) { return b.pass; });
}

// NaN reaches no bar.
bool passes(const Measured& value, double bar, bool required) {
  return value ? std::abs(*value) <= bar : !required;
}

Measured holdout_ratio(const calib::CameraQuality& q) {
  if (!q.holdout_px) return q.holdout_px;
  if (!q.rms_px || !(*q.rms_px > 0)) return Measured::not_measured("the points fit without any error");
  return {*q.holdout_px / *q.rms_px, q.holdout_px.count()};
}

}  // namespace

Verdict judge(const calib::Calibration& c, const CalibrationBars& bars) {
  return judge(c, bars, calib::hull_of_targets(c));
}

Verdict judge(const calib::Calibration& c, const CalibrationBars& bars, const calib::WorkingVolume& volume) {
  Verdict v;
  const auto check = [&](const char* what, const std::string& camera, const Measured& value, double bar) {
    v.checks.push_back({what, camera, value, bar, passes(value, bar, false)});
  };
  const calib::ProjectionUncertainty uncertainty(c, volume.points);
  for (std::size_t i = 0; i < c.cameras.size(); ++i) {
    const calib::CameraQuality& q = c.cameras[i];
    if (q.points == 0) continue;
    check("rms_px", q.serial, q.rms_px, bars.rms_px);
    check("p95_px", q.serial, q.p95_px, bars.p95_px);
    check("holdout_ratio", q.serial, holdout_ratio(q), bars.holdout_ratio);
    // What was given, and the camera that others are relative to, have no sigma by definition: no finding.
    if (q.intrinsics_sigma[0] > 0)
      check("focal_sigma_percent", q.serial,
            {100 * q.intrinsics_sigma[0] / c.rig.cameras[i].model.fx, q.points}, bars.focal_sigma_percent);
    if (q.rotation_sigma_degrees)
      check("rotation_sigma_degrees", q.serial, q.rotation_sigma_degrees, bars.rotation_sigma_degrees);
    check("projection_sigma_px", q.serial,
          calib::projection_sigma(c, uncertainty, static_cast<int>(i), volume), bars.projection_sigma_px);
  }
  check("scale_rms_mm", "", c.scale.figure(c.scale.rms_mm), bars.scale_rms_mm);
  check("scale_bias_mm", "", c.scale.figure(c.scale.bias_mm), bars.scale_bias_mm);
  sum_up(v, c);
  return v;
}

void add_check(Verdict& v, const calib::Calibration& c, BarCheck check) {
  check.pass = passes(check.value, check.bar, check.required);
  v.checks.push_back(std::move(check));
  sum_up(v, c);
}

std::string describe(const calib::Calibration& c, const Verdict& v) {
  std::string out = v.pass ? "PASS" : "FAIL";
  for (const calib::NamedFailure& f : c.failures) out += text("\n  ", name_of(f.kind), ": ", f.sentence);
  // One reason and all its cameras in a line: a rig of thirty cameras lacks the same thing thirty times.
  std::map<std::pair<std::string, std::string>, std::string> missing;
  for (const BarCheck& b : v.checks) {
    const std::string of = b.camera.empty() ? "" : text(" of camera '", b.camera, "'");
    if (b.value && !b.pass)
      out += text("\n  ", b.what, of, " is ", *b.value, ", the bar is ", b.bar);
    else if (!b.value) {
      std::string& cameras = missing[{b.what + (b.required ? ", which has a bar," : ""), b.value.because()}];
      if (!b.camera.empty()) cameras += text(cameras.empty() ? "" : ", ", b.camera);
    }
  }
  for (const auto& [what, cameras] : missing)
    out += text("\n  ", what.first, cameras.empty() ? "" : " (", cameras, cameras.empty() ? "" : ")",
                " was not measured, because ", what.second);
  return out;
}

}  // namespace floatstage::pipeline
