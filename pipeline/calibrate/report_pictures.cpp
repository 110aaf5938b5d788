#include "pipeline/calibrate/report_pictures.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <utility>
#include <vector>

#include "core/statistics.h"
#include "core/text.h"

namespace floatstage::pipeline {
namespace {

constexpr double kWidth = 320;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

std::string number(double v) { return text(std::fixed, std::setprecision(1), v); }

std::string begin_svg(double width, double height, const std::string& title) {
  return text("<svg viewBox=\"0 0 ", number(width), ' ', number(height), "\" width=\"", number(width),
              "\" role=\"img\"><title>", escaped(title),
              "</title><rect width=\"100%\" height=\"100%\" fill=\"#f4f4f2\"/>");
}

// From pale to dark through one hue, so that it reads in grey too; 0..1.
std::string shade(double share) {
  share = std::clamp(std::isfinite(share) ? share : 1.0, 0.0, 1.0);
  const auto mix = [&](int pale, int dark) {
    return static_cast<int>(std::lround(pale + (dark - pale) * share));
  };
  return text("rgb(", mix(236, 8), ',', mix(242, 48), ',', mix(248, 107), ')');
}

std::string cell(double x, double y, double w, double h, const std::string& fill, const std::string& title) {
  return text("<rect x=\"", number(x), "\" y=\"", number(y), "\" width=\"", number(w), "\" height=\"",
              number(h), "\" fill=\"", fill, "\"><title>", title, "</title></rect>");
}

// What shades mean, in a row below a picture: a patch and its value each.
constexpr double kLegend = 24;
std::string legend(double top, const std::vector<std::pair<std::string, double>>& shades) {
  const double step = kWidth / static_cast<double>(shades.size());
  std::string out;
  for (std::size_t i = 0; i < shades.size(); ++i) {
    const double x = static_cast<double>(i) * step;
    out += cell(x + 2, top + 7, 14, 12, shade(shades[i].second), shades[i].first) +
           text("<text x=\"", number(x + 20), "\" y=\"", number(top + 17),
                "\" font-size=\"11\" fill=\"#333\">", shades[i].first, "</text>");
  }
  return out;
}

constexpr int kColumns = 16, kRows = 12;

double scale_of(const CameraModel& m) { return kWidth / m.width; }

}  // namespace

std::string escaped(const std::string& raw) {
  std::string out;
  for (const char c : raw) {
    if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '&')
      out += "&amp;";
    else if (c == '"')
      out += "&quot;";
    else
      out += c;
  }
  return out;
}

std::string error_picture(const calib::Calibration& c, int camera) {
  const CameraModel& m = c.rig.cameras[at(camera)].model;
  const double scale = scale_of(m),
               rms = c.cameras[at(camera)].rms_px ? std::max(*c.cameras[at(camera)].rms_px, 1e-6) : 1;
  const double longer = 8 / rms;  // an error as large as the RMS is 8 px long
  std::string kept, left_out;
  std::size_t count = 0;
  for (const calib::PointError& e : c.errors) count += e.camera == camera;
  constexpr std::size_t kMost = 2000;  // more is a blot, and a heavy page
  const std::size_t step = count / kMost + 1;
  std::size_t i = 0;
  for (const calib::PointError& e : c.errors) {
    if (e.camera != camera || !e.error.allFinite()) continue;
    const Eigen::Vector2d p = e.pixel * scale;
    if (!e.kept) {
      left_out += text("<circle cx=\"", number(p.x()), "\" cy=\"", number(p.y()), "\" r=\"1.6\"/>");
    } else if (i++ % step == 0) {
      const Eigen::Vector2d d = e.error * longer;
      kept += text('M', number(p.x()), ' ', number(p.y()), 'l', number(d.x()), ' ', number(d.y()));
    }
  }
  return begin_svg(kWidth, m.height * scale, "errors") +
         text("<path d=\"", kept,
              "\" stroke=\"#08306b\" stroke-width=\"0.7\" fill=\"none\"/><g fill=\"#c0392b\">", left_out,
              "</g></svg>");
}

std::string coverage_picture(const calib::Calibration& c, int camera) {
  const CameraModel& m = c.rig.cameras[at(camera)].model;
  std::vector<int> counts(kColumns * kRows);
  for (const calib::PointError& e : c.errors) {
    if (e.camera != camera || !e.kept || !inside(m, e.pixel)) continue;
    ++counts[at(static_cast<int>(e.pixel.y() / m.height * kRows) * kColumns +
                static_cast<int>(e.pixel.x() / m.width * kColumns))];
  }
  const double most = std::max(1, *std::max_element(counts.begin(), counts.end()));
  const double height = m.height * scale_of(m), w = kWidth / kColumns, h = height / kRows;
  std::string out = begin_svg(kWidth, height + kLegend, "coverage");
  for (int r = 0; r < kRows; ++r)
    for (int k = 0; k < kColumns; ++k)
      if (const int n = counts[at(r * kColumns + k)]; n > 0)
        out += cell(k * w, r * h, w, h, shade(std::sqrt(n / most)), text(n, " points"));
  std::vector<std::pair<std::string, double>> shades;
  for (const double share : {0.0, 0.1, 0.25, 0.5, 1.0})
    shades.emplace_back(text(std::lround(share * most), share > 0 ? "" : " points"), std::sqrt(share));
  return out + legend(height, shades) + "</svg>";
}

std::string uncertainty_picture(const calib::Calibration& c, const calib::ProjectionUncertainty& uncertainty,
                                int camera) {
  const RigCamera& rc = c.rig.cameras[at(camera)];
  std::vector<double> depths;
  for (const calib::PointError& e : c.errors)
    if (e.camera == camera && e.kept) depths.push_back(e.depth);
  const double height = rc.model.height * scale_of(rc.model), w = kWidth / kColumns, h = height / kRows;
  std::string out = begin_svg(kWidth, height + kLegend, "projection uncertainty");
  if (depths.empty()) return out + "</svg>";
  const double depth = median(std::move(depths));
  constexpr double kDarkest = 1;  // px
  for (int r = 0; r < kRows; ++r)
    for (int k = 0; k < kColumns; ++k) {
      const std::optional<Eigen::Vector3d> ray =
          unproject(rc.model, {(k + 0.5) * rc.model.width / kColumns, (r + 0.5) * rc.model.height / kRows});
      if (!ray) continue;
      const double sigma = uncertainty.sigma_px(camera, rc.cam_from_world.inverse() * (*ray * depth));
      out += cell(k * w, r * h, w, h, shade(std::sqrt(sigma / kDarkest)),
                  text(std::setprecision(2), sigma, " px"));
    }
  std::vector<std::pair<std::string, double>> shades;
  for (const double px : {0.0, 0.1, 0.3, kDarkest})
    shades.emplace_back(text(px < kDarkest ? "" : "≥ ", px, " px"), std::sqrt(px / kDarkest));
  return out + legend(height, shades) + "</svg>";
}

std::string graph_picture(const calib::Calibration& c) {
  constexpr double kSize = 420, kMargin = 50;
  if (c.rig.cameras.empty()) return "";
  Eigen::Vector2d low = c.rig.cameras[0].cam_from_world.center().head<2>(), high = low;
  for (const RigCamera& rc : c.rig.cameras) {
    low = low.cwiseMin(rc.cam_from_world.center().head<2>());
    high = high.cwiseMax(rc.cam_from_world.center().head<2>());
  }
  const double scale = (kSize - 2 * kMargin) / std::max(1e-3, (high - low).maxCoeff());
  const Eigen::Vector2d middle = 0.5 * (low + high);
  const auto place = [&](const Eigen::Vector3d& p) {  // x to the right, y up
    return Eigen::Vector2d(kSize / 2 + (p.x() - middle.x()) * scale,
                           kSize / 2 - (p.y() - middle.y()) * scale);
  };
  int most = 1;
  for (const calib::CameraLink& l : c.links) most = std::max(most, l.points);
  std::string out = begin_svg(kSize, kSize, "cameras from above");
  for (const calib::CameraLink& l : c.links) {
    const Eigen::Vector2d a = place(c.rig.cameras[at(l.a)].cam_from_world.center()),
                          b = place(c.rig.cameras[at(l.b)].cam_from_world.center());
    out += text("<line x1=\"", number(a.x()), "\" y1=\"", number(a.y()), "\" x2=\"", number(b.x()),
                "\" y2=\"", number(b.y()), "\" stroke=\"", l.in_tree ? "#08306b" : "#9bb4cf",
                "\" stroke-width=\"", number(0.6 + 4.0 * l.points / most), "\"><title>",
                escaped(c.rig.cameras[at(l.a)].serial), " and ", escaped(c.rig.cameras[at(l.b)].serial), ": ",
                l.frames, " frames, ", l.points, " points</title></line>");
  }
  for (const RigCamera& rc : c.rig.cameras) {
    const Eigen::Vector3d center = rc.cam_from_world.center(),
                          ahead = rc.cam_from_world.rotation.conjugate() * Eigen::Vector3d::UnitZ();
    const Eigen::Vector2d p = place(center), d = 18 * Eigen::Vector2d(ahead.x(), -ahead.y());
    out += text("<line x1=\"", number(p.x()), "\" y1=\"", number(p.y()), "\" x2=\"", number(p.x() + d.x()),
                "\" y2=\"", number(p.y() + d.y()), "\" stroke=\"#222\" stroke-width=\"2\"/><circle cx=\"",
                number(p.x()), "\" cy=\"", number(p.y()), "\" r=\"5\" fill=\"#222\"/><text x=\"",
                number(p.x() + 8), "\" y=\"", number(p.y() - 8), "\" font-size=\"12\">", escaped(rc.serial),
                "</text>");
  }
  return out + "</svg>";
}

}  // namespace floatstage::pipeline
