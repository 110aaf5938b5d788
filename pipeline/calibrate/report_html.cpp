#include <algorithm>
#include <cmath>
#include <iomanip>

#include "core/text.h"
#include "pipeline/calibrate/report.h"
#include "pipeline/calibrate/report_pictures.h"

namespace floatstage::pipeline {
namespace {

constexpr const char* kStyle =
    "body{font:15px/1.45 system-ui,sans-serif;max-width:1080px;margin:2em auto;padding:0 "
    "1em;color:#1a1a1a;background:#fff}"
    "h1{font-size:1.5em}h2{font-size:1.15em;margin-top:2em}table{border-collapse:collapse;font-variant-"
    "numeric:tabular-nums}"
    "td,th{padding:.2em .7em;text-align:right;border-bottom:1px solid "
    "#ddd}td:first-child,th:first-child{text-align:left}"
    ".pass{color:#1d6b34;font-weight:600}.fail{color:#b3261e;font-weight:600}figure{display:inline-block;"
    "margin:.4em .6em .4em 0;vertical-align:top}"
    "figcaption{font-size:.85em;color:#555;max-width:320px}svg{max-width:100%;height:auto}li{margin:.3em 0}";

std::string rounded(double v, int digits = 3) { return text(std::fixed, std::setprecision(digits), v); }

// In a table a dash, which says why when it is pointed at.
std::string rounded(const Measured& m, int digits = 3) {
  return m ? rounded(*m, digits) : text("<span title=\"", escaped(to_words(m, digits)), "\">–</span>");
}

const char* word(bool pass) {
  return pass ? "<span class=\"pass\">PASS</span>" : "<span class=\"fail\">FAIL</span>";
}

std::string items(const std::vector<std::string>& sentences) {
  std::string out;
  for (const std::string& s : sentences) out += "<li>" + escaped(s) + "</li>";
  return out.empty() ? "" : "<ul>" + out + "</ul>";
}

std::string camera_table(const calib::Calibration& c) {
  std::string out =
      "<table><tr><th>camera</th><th>RMS px</th><th>P95 px</th><th>held out px</th><th>points</th><th>left "
      "out</th><th>focal px</th><th>± px</th>"
      "<th>rotation ± °</th><th>position ± mm</th><th>depth ratio</th><th>tilt °</th><th>covered</th></tr>";
  for (std::size_t i = 0; i < c.cameras.size(); ++i) {
    const calib::CameraQuality& q = c.cameras[i];
    out += text("<tr><td>", escaped(q.serial), "</td><td>", rounded(q.rms_px), "</td><td>", rounded(q.p95_px),
                "</td><td>", rounded(q.holdout_px), "</td><td>", q.points, "</td><td>", q.outliers,
                "</td><td>", rounded(c.rig.cameras[i].model.fx, 2), "</td><td>",
                q.intrinsics_sigma[0] > 0 ? rounded(q.intrinsics_sigma[0]) : "given", "</td><td>",
                rounded(q.rotation_sigma_degrees, 4), "</td><td>", rounded(q.position_sigma_mm), "</td><td>",
                rounded(q.depth_ratio, 2), "</td><td>", rounded(q.tilt_degrees, 0), "</td><td>",
                rounded(100 * q.covered, 0), " %</td></tr>");
  }
  return out + "</table>";
}

std::string bar_table(const Verdict& v) {
  // One row a bar: the camera that is furthest from it.
  std::vector<const BarCheck*> worst;
  for (const BarCheck& b : v.checks) {
    const auto same =
        std::find_if(worst.begin(), worst.end(), [&](const BarCheck* w) { return w->what == b.what; });
    if (same == worst.end())
      worst.push_back(&b);
    else if (b.value && (!(*same)->value || !(std::abs(*b.value) <= std::abs(*(*same)->value))))
      *same = &b;
  }
  std::string out = "<table><tr><th>bar</th><th>worst</th><th>at most</th><th>camera</th><th></th></tr>";
  for (const BarCheck* b : worst)
    out += text("<tr><td>", b->what, "</td><td>",
                b->value ? rounded(b->value, 4) : escaped(to_words(b->value, 4)), "</td><td>",
                rounded(b->bar, 4), "</td><td>", escaped(b->camera), "</td><td>",
                b->value || b->required ? word(b->pass) : "–", "</td></tr>");
  return out + "</table>";
}

std::string length_table(const calib::Calibration& c) {
  if (c.lengths.empty()) return "<p>No length was seen by two cameras at a good angle.</p>";
  std::string out =
      "<table><tr><th>target</th><th>lengths</th><th>RMS mm</th><th>bias mm</th><th>measured / "
      "known</th></tr>";
  for (const calib::LengthQuality& l : c.lengths)
    out += text("<tr><td>", escaped(l.target), "</td><td>", l.count, "</td><td>", rounded(l.rms_mm),
                "</td><td>", rounded(l.bias_mm), "</td><td>", rounded(l.ratio, 5), " ± ",
                rounded(l.ratio_sigma, 5), "</td></tr>");
  return out + "</table>";
}

std::string figure(const std::string& picture, const std::string& caption) {
  return "<figure>" + picture + "<figcaption>" + escaped(caption) + "</figcaption></figure>";
}

}  // namespace

std::string report_html(const calib::Calibration& c, const Verdict& v, const ReportContext& context) {
  std::string out = text(
      "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
      "content=\"width=device-width\"><title>Calibration ",
      escaped(context.title), "</title><style>", kStyle, "</style></head><body><h1>Calibration ",
      escaped(context.title), ": ", word(v.pass), "</h1>");
  if (!c.failures.empty()) {
    out += "<h2>What is wrong with the capture</h2><ul>";
    for (const calib::NamedFailure& f : c.failures)
      out += text("<li><b>", name_of(f.kind), "</b>: ", escaped(f.sentence), "</li>");
    out += "</ul>";
  }
  if (!v.checks.empty()) out += "<h2>Bars</h2>" + bar_table(v);
  if (!c.cameras.empty()) {
    out += "<h2>Cameras</h2>" + camera_table(c);
    out += text("<p>± are standard deviations of the solution; of poses, ",
                c.reference >= 0 ? "relative to camera " +
                                       escaped(c.rig.cameras[static_cast<std::size_t>(c.reference)].serial)
                                 : std::string("in the given world"),
                ".</p>");
    if (c.jitter_ms)
      out += text("<p>Pictures stray by ", rounded(c.jitter_ms, 1),
                  " ms (one standard deviation) from their cameras' instants.</p>");
    out += "<h2>Known lengths, measured by the cameras alone</h2>" + length_table(c);
    out += "<h2>Cameras from above</h2>" +
           figure(graph_picture(c),
                  "Lines join cameras that saw the target together; the start went along the dark ones.");
    const calib::WorkingVolume volume =
        context.volume.points.empty() ? calib::hull_of_targets(c) : context.volume;
    out += "<p>Projection sigmas are taken over " + escaped(volume.how) + ".</p>";
    const calib::ProjectionUncertainty uncertainty(c, volume.points);
    for (std::size_t i = 0; i < c.cameras.size(); ++i) {
      const int camera = static_cast<int>(i);
      out += text("<h2>Camera ", escaped(c.cameras[i].serial), "</h2>");
      out += figure(error_picture(c, camera),
                    text("Errors, enlarged ",
                         rounded(8 / std::max(c.cameras[i].rms_px ? *c.cameras[i].rms_px : 0, 1e-6) *
                                     c.rig.cameras[i].model.width / 320,
                                 0),
                         "×. A pattern is a lens that the model does not fit; red was left out."));
      out += figure(coverage_picture(c, camera),
                    "Where the target was seen. White corners are guessed by the lens model.");
      out += figure(uncertainty_picture(c, uncertainty, camera),
                    "How far off the calibration lets a pixel be at the targets' depth.");
    }
  }
  out += "<h2>Detection</h2>" + items(context.detection);
  std::vector<std::string> remarks = context.remarks;
  remarks.insert(remarks.end(), c.remarks.begin(), c.remarks.end());
  if (!remarks.empty()) out += "<h2>Remarks</h2>" + items(remarks);
  return out + text("<p>Detected in ", rounded(context.detection_seconds, 1), " s, solved in ",
                    rounded(c.seconds, 1), " s.</p></body></html>\n");
}

}  // namespace floatstage::pipeline
