#include "pipeline/calibrate/verdict.h"

#include <algorithm>
#include <cmath>

#include "core/statistics.h"
#include "core/text.h"
#include "pipeline/calibrate/report_pictures.h"

namespace floatstage::pipeline {
namespace {

void sum_up(Verdict& v, const calib::Calibration& c) {
  v.pass = !v.checks.empty() && c.failures.empty() &&
           std::all_of(v.checks.begin(), v.checks.end(), [](const BarCheck& b) { return b.pass; });
}

// The median over where a camera saw targets; absent when it saw none.
std::optional<double> projection_sigma(const calib::Calibration& c,
                                       const calib::ProjectionUncertainty& uncertainty, std::size_t camera) {
  const RigCamera& rc = c.rig.cameras[camera];
  const Rigid3 world_from_cam = rc.cam_from_world.inverse();
  std::vector<double> sigmas;
  for (const calib::PointError& e : c.errors) {
    if (e.camera != static_cast<int>(camera) || !e.kept) continue;
    if (const std::optional<Eigen::Vector3d> ray = unproject(rc.model, e.pixel))
      sigmas.push_back(
          uncertainty.sigma_px(e.camera, world_from_cam * Eigen::Vector3d(*ray * (e.depth / ray->z()))));
  }
  if (sigmas.empty()) return std::nullopt;
  return median(std::move(sigmas));
}

}  // namespace

Verdict judge(const calib::Calibration& c, const CalibrationBars& bars) {
  Verdict v;
  // NaN reaches no bar.
  const auto check = [&](const char* what, const std::string& camera, double value, double bar) {
    v.checks.push_back({what, camera, value, bar, std::abs(value) <= bar});
  };
  const calib::ProjectionUncertainty uncertainty(c, target_volume(c));
  for (std::size_t i = 0; i < c.cameras.size(); ++i) {
    const calib::CameraQuality& q = c.cameras[i];
    if (q.points == 0) continue;
    check("rms_px", q.serial, q.rms_px, bars.rms_px);
    check("p95_px", q.serial, q.p95_px, bars.p95_px);
    if (q.holdout_px > 0 && q.rms_px > 0)
      check("holdout_ratio", q.serial, q.holdout_px / q.rms_px, bars.holdout_ratio);
    check("focal_sigma_percent", q.serial, 100 * q.intrinsics_sigma[0] / c.rig.cameras[i].model.fx,
          bars.focal_sigma_percent);
    check("rotation_sigma_degrees", q.serial, q.rotation_sigma_degrees, bars.rotation_sigma_degrees);
    if (const std::optional<double> sigma = projection_sigma(c, uncertainty, i))
      check("projection_sigma_px", q.serial, *sigma, bars.projection_sigma_px);
  }
  if (c.scale.count > 0) {
    check("scale_rms_mm", "", c.scale.rms_mm, bars.scale_rms_mm);
    check("scale_bias_mm", "", c.scale.bias_mm, bars.scale_bias_mm);
  }
  sum_up(v, c);
  return v;
}

void add_check(Verdict& v, const calib::Calibration& c, BarCheck check) {
  check.pass = std::abs(check.value) <= check.bar;
  v.checks.push_back(std::move(check));
  sum_up(v, c);
}

std::string describe(const calib::Calibration& c, const Verdict& v) {
  if (v.pass) return "PASS";
  std::string out = "FAIL";
  for (const calib::NamedFailure& f : c.failures) out += text("\n  ", name_of(f.kind), ": ", f.sentence);
  for (const BarCheck& b : v.checks)
    if (!b.pass)
      out += text("\n  ", b.what, b.camera.empty() ? "" : " of camera '", b.camera,
                  b.camera.empty() ? "" : "'", " is ", b.value, ", the bar is ", b.bar);
  return out;
}

}  // namespace floatstage::pipeline
