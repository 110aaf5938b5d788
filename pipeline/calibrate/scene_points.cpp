#include "pipeline/calibrate/scene_points.h"

#include <cmath>
#include <iomanip>

#include <Eigen/Dense>

#include "core/text.h"

namespace floatstage::pipeline {

Result<ScenePoints> measure_points(const std::vector<SessionPoint>& points, const Rig& rig) {
  ScenePoints out;
  std::vector<double> squares(rig.cameras.size());
  std::vector<int> counts(rig.cameras.size());
  for (const SessionPoint& point : points) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const SessionPoint::Seen& s : point.seen) {
      const int index = camera_index(rig, s.serial);
      if (index < 0)
        return fail(ErrorCode::NotFound,
                    text("point '", point.name, "' is seen by camera '", s.serial, "', which the rig lacks"));
      const RigCamera& c = rig.cameras[static_cast<std::size_t>(index)];
      const std::optional<Eigen::Vector3d> ray = unproject(c.model, s.pixel);
      if (!ray)
        return fail(ErrorCode::BadData, text("point '", point.name, "' lies where the lens of camera '",
                                             s.serial, "' sees nothing"));
      const Eigen::Vector3d along = (c.cam_from_world.rotation.conjugate() * *ray).normalized();
      const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - along * along.transpose();
      normal += across;
      right += across * c.cam_from_world.center();
    }
    const Eigen::Vector3d place = normal.ldlt().solve(right);
    for (const SessionPoint::Seen& s : point.seen) {
      const auto index = static_cast<std::size_t>(camera_index(rig, s.serial));
      const RigCamera& c = rig.cameras[index];
      const std::optional<Eigen::Vector2d> pixel = project(c.model, c.cam_from_world * place);
      if (!pixel)
        return fail(ErrorCode::BadData, text("point '", point.name, "': its rays do not meet before camera '",
                                             s.serial, "'; is it the same point in all pictures?"));
      squares[index] += (*pixel - s.pixel).squaredNorm();
      ++counts[index];
    }
    out.places.push_back(place);
  }
  double sum = 0;
  int count = 0;
  for (std::size_t c = 0; c < squares.size(); ++c) {
    out.camera_rms_px.push_back(
        Measured::of(counts[c] > 0 ? std::sqrt(squares[c] / counts[c]) : 0, counts[c], "it saw no point"));
    sum += squares[c];
    count += counts[c];
  }
  out.rms_px = Measured::of(count > 0 ? std::sqrt(sum / count) : 0, count, "no camera saw a point");
  return out;
}

std::string describe(const ScenePoints& measured, const Rig& rig, const std::string& which) {
  std::string cameras;
  for (std::size_t c = 0; c < rig.cameras.size(); ++c)
    if (measured.camera_rms_px[c])
      cameras += text(cameras.empty() ? "" : ", ", rig.cameras[c].serial, " ", std::fixed,
                      std::setprecision(1), *measured.camera_rms_px[c]);
  return text(measured.places.size(), " points of the scene meet within ",
              to_words(measured.rms_px, 1, " px"), " in the ", which, " rig (", cameras, ")");
}

}  // namespace floatstage::pipeline
