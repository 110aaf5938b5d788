#include "pipeline/film_cameras.h"

#include <algorithm>
#include <cmath>

namespace floatstage::pipeline {
namespace {

constexpr double kNearest = 0.1;    // metres to what a camera looks at
constexpr double kSameTime = 1e-6;  // seconds

}  // namespace

std::vector<FilmCamera> film_cameras(const CameraPath& path, double rate, const SubjectTrack& subject,
                                     FilmTimes times) {
  const bool shows = path.has_take_times();
  std::vector<FilmCamera> cameras;
  const auto add = [&](double time) {
    const PathKey key = sample(path, time, subject);
    FilmCamera camera{
        time, look_at(key.eye, key.target, key.up), key.fov_y, (key.target - key.eye).norm(), {}};
    if (shows) camera.take_time = take_time(path, time);
    cameras.push_back(camera);
  };
  const double pictures = path.duration() * rate;
  const int last = times == FilmTimes::Pictures ? std::max(1, static_cast<int>(std::lround(pictures))) - 1
                                                : static_cast<int>(std::floor(pictures + kSameTime * rate));
  for (int i = 0; i <= last; ++i) add(i / rate);
  if (times == FilmTimes::WithEnd && path.duration() > cameras.back().time + kSameTime) add(path.duration());
  return cameras;
}

CameraPath path_through(const std::vector<FilmCamera>& cameras) {
  CameraPath path;
  for (const FilmCamera& camera : cameras) {
    const Eigen::Matrix3d axes = camera.cam_from_world.rotation.toRotationMatrix();
    const Eigen::Vector3d forward = axes.row(2);
    PathKey key;
    key.time = camera.time;
    key.eye = camera.cam_from_world.center();
    key.target = key.eye + forward * camera.distance.value_or(std::max(kNearest, -forward.dot(key.eye)));
    key.up = -axes.row(1);
    key.fov_y = camera.fov_y;
    key.take_time = camera.take_time;
    path.keys.push_back(key);
  }
  return path;
}

}  // namespace floatstage::pipeline
