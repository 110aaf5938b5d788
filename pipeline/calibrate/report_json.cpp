#include <cmath>

#include <nlohmann/json.hpp>

#include "core/file.h"
#include "pipeline/calibrate/report.h"
#include "pipeline/json_report.h"

namespace floatstage::pipeline {
namespace {

using Json = nlohmann::json;

Json sigma_json(const calib::CameraQuality& q, const CameraModel& model) {
  const char* const names[] = {"fx", "fy", "cx", "cy"};
  const char* const brown[] = {"k1", "k2", "p1", "p2", "k3"};
  const char* const fisheye[] = {"k1", "k2", "k3", "k4"};
  Json out;
  for (int i = 0; i < 4; ++i) out[names[i]] = q.intrinsics_sigma[i];
  if (std::holds_alternative<BrownConrady>(model.lens))
    for (int i = 0; i < 5; ++i) out[brown[i]] = q.intrinsics_sigma[4 + i];
  if (std::holds_alternative<KannalaBrandt>(model.lens))
    for (int i = 0; i < 4; ++i) out[fisheye[i]] = q.intrinsics_sigma[4 + i];
  out["rotation_degrees"] = q.rotation_sigma_degrees;
  out["position_mm"] = q.position_sigma_mm;
  return out;
}

Json camera_json(const calib::CameraQuality& q, const CameraModel& model) {
  Json out = {{"serial", q.serial},
              {"views", q.views},
              {"points", q.points},
              {"outliers", q.outliers},
              {"rms_px", q.rms_px},
              {"p95_px", q.p95_px},
              {"holdout_px", q.holdout_px},
              {"depth_ratio", q.depth_ratio},
              {"tilt_degrees", q.tilt_degrees},
              {"covered", q.covered},
              {"fx", model.fx},
              {"fy", model.fy},
              {"sigma", sigma_json(q, model)}};
  if (q.time_offset_sigma_ms > 0)
    out["time_offset_ms"] = {{"value", q.time_offset_ms}, {"sigma", q.time_offset_sigma_ms}};
  if (q.moved_mm) out["moved"] = {{"mm", *q.moved_mm}, {"degrees", *q.turned_degrees}};
  return out;
}

Json length_json(const calib::LengthQuality& l) {
  return {{"target", l.target},   {"count", l.count}, {"rms_mm", l.rms_mm},
          {"bias_mm", l.bias_mm}, {"ratio", l.ratio}, {"ratio_sigma", l.ratio_sigma}};
}

}  // namespace

nlohmann::json report_json(const calib::Calibration& c, const Verdict& v, const ReportContext& context) {
  Json cameras = Json::array(), lengths = Json::array(), failures = Json::array(), bars = Json::array(),
       links = Json::array();
  for (std::size_t i = 0; i < c.cameras.size(); ++i)
    cameras.push_back(camera_json(c.cameras[i], c.rig.cameras[i].model));
  for (const calib::LengthQuality& l : c.lengths) lengths.push_back(length_json(l));
  for (const calib::NamedFailure& f : c.failures)
    failures.push_back({{"name", name_of(f.kind)}, {"camera", f.camera}, {"sentence", f.sentence}});
  for (const BarCheck& b : v.checks)
    bars.push_back(
        {{"what", b.what}, {"camera", b.camera}, {"value", b.value}, {"bar", b.bar}, {"pass", b.pass}});
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
  return {{"pass", v.pass},
          {"cameras", cameras},
          {"scale", scale},
          {"lengths", lengths},
          {"failures", failures},
          {"bars", bars},
          {"links", links},
          {"remarks", remarks},
          {"detection", context.detection},
          {"jitter_ms", c.jitter_ms},
          {"reference", c.reference >= 0 ? Json(c.rig.cameras[static_cast<std::size_t>(c.reference)].serial)
                                         : Json(nullptr)},
          {"detection_seconds", context.detection_seconds},
          {"seconds", c.seconds}};
}

Result<void> save_report(const calib::Calibration& c, const Verdict& v, const ReportContext& context,
                         const std::filesystem::path& folder) {
  if (Result<void> ok = make_folder(folder); !ok) return ok;
  if (Result<void> ok = write_file(folder / "calibration.html", report_html(c, v, context)); !ok) return ok;
  return save_json(report_json(c, v, context), folder / "calibration.json");
}

}  // namespace floatstage::pipeline
