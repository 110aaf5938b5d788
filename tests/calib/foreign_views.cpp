#include "tests/calib/foreign_views.h"

#include <algorithm>
#include <iomanip>
#include <regex>
#include <sstream>
#include <stdexcept>

#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>

#include "calib/child_program.h"
#include "core/file.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

// OpenCV's lens on points in the camera's frame, and then all of K: projectPoints itself ignores a skew.
std::vector<Eigen::Vector2d> pixels_by_opencv(const CameraModel& m,
                                              const std::vector<Eigen::Vector3d>& in_camera) {
  const auto* brown = std::get_if<BrownConrady>(&m.lens);
  const auto* fisheye = std::get_if<KannalaBrandt>(&m.lens);
  const cv::Matx33d unit = cv::Matx33d::eye();
  const cv::Vec3d none(0, 0, 0);
  std::vector<cv::Point3d> points;
  for (const Eigen::Vector3d& x : in_camera) points.emplace_back(x.x(), x.y(), x.z());
  std::vector<cv::Point2d> bent;
  if (fisheye)
    cv::fisheye::projectPoints(points, bent, none, none, unit,
                               cv::Vec4d(fisheye->k1, fisheye->k2, fisheye->k3, fisheye->k4));
  else
    cv::projectPoints(points, none, none, unit,
                      brown ? cv::Mat(cv::Matx<double, 1, 8>(brown->k1, brown->k2, brown->p1, brown->p2,
                                                             brown->k3, brown->k4, brown->k5, brown->k6))
                            : cv::Mat(),
                      bent);
  std::vector<Eigen::Vector2d> out;
  for (const cv::Point2d& p : bent) out.emplace_back(m.fx * p.x + m.skew * p.y + m.cx, m.fy * p.y + m.cy);
  return out;
}

cv::Mat matrix_of(const cv::FileStorage& file, const std::string& key) {
  cv::Mat out;
  file[key] >> out;
  if (out.empty()) throw std::runtime_error(key + " is missing");
  return out;
}

// The export's images with sights of points, and the points: COLMAP then starts from no error of ours.
void add_points(const Rig& rig, const std::filesystem::path& folder) {
  const Result<std::string> images = read_file(folder / "images.txt");
  ASSERT_TRUE(images.has_value());
  const double distance = (focus_point(rig) - rig.cameras[0].cam_from_world.center()).norm();
  std::vector<std::string> sights(rig.cameras.size());
  std::vector<int> counts(rig.cameras.size());
  std::string points;
  int id = 0;
  for (const Eigen::Vector3d& x : points_before(rig.cameras[0], 0.9 * distance)) {
    std::vector<std::pair<std::size_t, Eigen::Vector2d>> seen;
    for (std::size_t c = 0; c < rig.cameras.size(); ++c)
      if (const auto pixel = project(rig.cameras[c].model, rig.cameras[c].cam_from_world * x);
          pixel && inside(rig.cameras[c].model, *pixel))
        seen.emplace_back(c, *pixel);
    if (seen.size() < 2) continue;  // COLMAP knows no others
    std::string track;
    ++id;
    for (const auto& [c, pixel] : seen) {
      sights[c] +=
          text(sights[c].empty() ? "" : " ", std::setprecision(17), pixel.x(), ' ', pixel.y(), ' ', id);
      track += text(' ', c + 1, ' ', counts[c]++);
    }
    points += text(id, std::setprecision(17), ' ', x.x(), ' ', x.y(), ' ', x.z(), " 0 0 0 0", track, '\n');
  }
  EXPECT_GE(id, 5) << "COLMAP has nothing to look at";
  std::string out, line;
  std::size_t camera = 0;
  std::istringstream in(*images);
  while (std::getline(in, line)) {
    if (line.empty() || line[0] == '#') continue;
    out += line + '\n' + sights[camera++] + '\n';
  }
  // Where there are both, COLMAP reads the binary files.
  for (const char* file : {"cameras.bin", "images.bin", "points3D.bin"})
    std::filesystem::remove(folder / file);
  EXPECT_TRUE(write_file(folder / "images.txt", out).has_value());
  EXPECT_TRUE(write_file(folder / "points3D.txt", points).has_value());
}

}  // namespace

std::vector<Eigen::Vector3d> points_before(const RigCamera& c, double distance) {
  std::vector<Eigen::Vector3d> out;
  for (int y = 0; y < 7; ++y)
    for (int x = 0; x < 9; ++x)
      if (const auto ray =
              unproject(c.model, {(x + 0.5) / 9 * c.model.width, (y + 0.5) / 7 * c.model.height}))
        out.push_back(c.cam_from_world.inverse() * Eigen::Vector3d(*ray * (distance * (1 + 0.1 * (x % 3)))));
  return out;
}

double furthest_by_opencv(const Rig& rig, const Rig& exported, const Rigid3& world) {
  double most = 0;
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const RigCamera &ours = rig.cameras[c], &theirs = exported.cameras[c];
    const std::vector<Eigen::Vector3d> points = points_before(ours);
    std::vector<Eigen::Vector3d> in_camera;
    for (const Eigen::Vector3d& x : points) in_camera.emplace_back(theirs.cam_from_world * (world * x));
    const std::vector<Eigen::Vector2d> pixels = pixels_by_opencv(theirs.model, in_camera);
    for (std::size_t i = 0; i < points.size(); ++i)
      most = std::max(most, (*project(ours.model, ours.cam_from_world * points[i]) - pixels[i]).norm());
  }
  return most;
}

Rig read_by_opencv(const std::filesystem::path& folder, const Rig& like) {
  const cv::FileStorage intri((folder / "intri.yml").string(), cv::FileStorage::READ),
      extri((folder / "extri.yml").string(), cv::FileStorage::READ);
  Rig out = like;
  for (RigCamera& c : out.cameras) {
    const cv::Mat k = matrix_of(intri, "K_" + c.serial), d = matrix_of(intri, "dist_" + c.serial),
                  r = matrix_of(extri, "Rot_" + c.serial), t = matrix_of(extri, "T_" + c.serial);
    // OpenCV's pixel (0,0) is the first pixel's centre.
    c.model = {.width = c.model.width,
               .height = c.model.height,
               .fx = k.at<double>(0, 0),
               .fy = k.at<double>(1, 1),
               .cx = k.at<double>(0, 2) + 0.5,
               .cy = k.at<double>(1, 2) + 0.5,
               .lens = {}};
    const auto term = [&](int i) { return i < static_cast<int>(d.total()) ? d.at<double>(i) : 0; };
    c.model.lens = BrownConrady{term(0), term(1), term(2), term(3), term(4), term(5), term(6), term(7)};
    Eigen::Matrix3d rotation;
    for (int y = 0; y < 3; ++y)
      for (int x = 0; x < 3; ++x) rotation(y, x) = r.at<double>(y, x);
    c.cam_from_world = {Eigen::Quaterniond(rotation).normalized(),
                        {t.at<double>(0), t.at<double>(1), t.at<double>(2)}};
  }
  return out;
}

std::optional<double> first_cost_of_colmap(const Rig& rig, const std::filesystem::path& model,
                                           const std::filesystem::path& out) {
  add_points(rig, model);
  const std::string log = (model / "log.txt").string();
  const Result<ProgramEnd> end = run_program(
      {"colmap", "bundle_adjuster", "--input_path", model.string(), "--output_path", out.string(),
       "--BundleAdjustment.max_num_iterations", "1", "--BundleAdjustment.refine_focal_length", "0",
       "--BundleAdjustment.refine_extra_params", "0", "--BundleAdjustment.refine_extrinsics", "0"},
      log, 60, nullptr);
  if (!end) return std::nullopt;
  const Result<std::string> said = read_file(log);
  std::smatch found;
  if (!said || !std::regex_search(*said, found, std::regex("Initial cost : ([0-9.e+-]+) \\[px\\]"))) {
    ADD_FAILURE() << (said ? *said : said.error().message);
    return std::nullopt;
  }
  return std::stod(found[1]);
}

}  // namespace floatstage::calib
