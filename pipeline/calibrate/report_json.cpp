#include <cmath>

#include <nlohmann/json.hpp>

#include "core/file.h"
#include "pipeline/calibrate/report.h"
#include "pipeline/json_report.h"
#include "pipeline/measured_json.h"

namespace floatstage::pipeline {
namespace {

using Json = nlohmann::json;

Json sigma_json(const calib::CameraQuality& q, const CameraModel& model) {
  const char* const names[] = {"fx", "fy", "cx", "cy"};
  const char* const brown[] = {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"};
  const char* const fisheye[] = {"k1", "k2", "k3", "k4"};
  Json out;
  const auto sigma = [&](const char* name, int row) {  // what is solved for is never known without a doubt
    const double s = q.intrinsics_sigma[row];
    put(out, name, Measured::of(s, s > 0 ? q.points : 0, "it was given or held and not solved for"));
  };
  for (int i = 0; i < 4; ++i) sigma(names[i], i);
  sigma("skew", 12);
  if (const auto* lens = std::get_if<BrownConrady>(&model.lens))
    for (int i = 0; i < (lens->rational() ? 8 : 5); ++i) sigma(brown[i], 4 + i);
  if (std::holds_alternative<KannalaBrandt>(model.lens))
    for (int i = 0; i < 4; ++i) sigma(fisheye[i], 4 + i);
  put(out, "rotation_degrees", q.rotation_sigma_degrees);
  put(out, "position_mm", q.position_sigma_mm);
  out.erase("counts");  // the camera's points, all of them
  return out;
}

Json camera_json(const calib::CameraQuality& q, const CameraModel& model) {
  Json out = {
      {"serial", q.serial},   {"views", q.views}, {"points", q.points}, {"outliers", q.outliers},
      {"covered", q.covered}, {"fx", model.fx},   {"fy", model.fy},     {"sigma", sigma_json(q, model)}};
  put(out, "rms_px", q.rms_px);
  put(out, "p95_px", q.p95_px);
  put(out, "holdout_px", q.holdout_px);
  put(out, "depth_ratio", q.depth_ratio);
  put(out, "tilt_degrees", q.tilt_degrees);
  if (q.time_offset_sigma_ms)
    out["time_offset_ms"] = {{"value", *q.time_offset_ms}, {"sigma", *q.time_offset_sigma_ms}};
  if (q.moved_mm) out["moved"] = {{"mm", *q.moved_mm}, {"degrees", *q.turned_degrees}};
  return out;
}

Json length_json(const calib::LengthQuality& l) {
  Json out = {{"target", l.target}, {"count", l.count}};
  put(out, "rms_mm", l.figure(l.rms_mm));
  put(out, "bias_mm", l.figure(l.bias_mm));
  put(out, "ratio", l.figure(l.ratio));
  put(out, "ratio_sigma", l.figure(l.ratio_sigma));
  out.erase("counts");
  return out;
}

// A bar of what was not measured is neither passed nor failed: null, unless it was asked for by name.
Json bar_json(const BarCheck& b) {
  Json out = {{"what", b.what}, {"camera", b.camera}, {"bar", b.bar}};
  put(out, "value", b.value);
  out["pass"] = b.value || b.required ? Json(b.pass) : Json(nullptr);
  return out;
}

}  // namespace

nlohmann::json report_json(const calib::Calibration& c, const Verdict& v, const ReportContext& context) {
  Json cameras = Json::array(), lengths = Json::array(), failures = Json::array(), bars = Json::array(),
       links = Json::array();
  for (std::size_t i = 0; i < c.cameras.size(); ++i) {
    cameras.push_back(camera_json(c.cameras[i], c.rig.cameras[i].model));
    if (i < c.scatter.size()) put(cameras.back(), "scatter", c.scatter[i]);
  }
  for (const calib::LengthQuality& l : c.lengths) lengths.push_back(length_json(l));
  for (const calib::NamedFailure& f : c.failures)
    failures.push_back({{"name", name_of(f.kind)}, {"camera", f.camera}, {"sentence", f.sentence}});
  for (const BarCheck& b : v.checks) bars.push_back(bar_json(b));
  for (const calib::CameraLink& l : c.links)
    links.push_back({{"a", c.rig.cameras[static_cast<std::size_t>(l.a)].serial},
                     {"b", c.rig.cameras[static_cast<std::size_t>(l.b)].serial},
                     {"frames", l.frames},
                     {"points", l.points},
                     {"in_tree", l.in_tree}});
  std::vector<std::string> remarks = context.remarks;
  remarks.insert(remarks.end(), c.remarks.begin(), c.remarks.end());
  Json scale = length_json(c.scale);
  scale.erase("target");
  Json out = {
      {"pass", v.pass},
      {"cameras", cameras},
      {"scale", scale},
      {"lengths", lengths},
      {"failures", failures},
      {"bars", bars},
      {"links", links},
      {"remarks", remarks},
      {"detection", context.detection},
      {"reference",
       c.reference >= 0 ? Json(c.rig.cameras[static_cast<std::size_t>(c.reference)].serial) : Json(nullptr)},
      {"detection_seconds", context.detection_seconds},
      {"seconds", c.seconds}};
  put(out, "jitter_ms", c.jitter_ms);
  const calib::WorkingVolume volume =
      context.volume.points.empty() ? calib::hull_of_targets(c) : context.volume;
  out["volume"] = {{"how", volume.how},
                   {"low", {volume.low.x(), volume.low.y(), volume.low.z()}},
                   {"high", {volume.high.x(), volume.high.y(), volume.high.z()}}};
  return out;
}

Result<void> save_report(const calib::Calibration& c, const Verdict& v, const ReportContext& context,
                         const std::filesystem::path& folder) {
  if (Result<void> ok = make_folder(folder); !ok) return ok;
  if (Result<void> ok = write_file(folder / "calibration.html", report_html(c, v, context)); !ok) return ok;
  return save_json(report_json(c, v, context), folder / "calibration.json");
}

}  // namespace floatstage::pipeline
