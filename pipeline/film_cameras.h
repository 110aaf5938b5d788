#pragma once

#include <optional>
#include <vector>

#include "core/camera.h"
#include "pipeline/camera_path.h"

namespace floatstage::pipeline {

/// Where a film's camera is at one time, in what other programs know of cameras.
struct FilmCamera {
  double time = 0;                       ///< seconds of the film
  Rigid3 cam_from_world = {};            ///< metres; x right, y down, z forward
  double fov_y = 40;                     ///< degrees
  std::optional<double> distance = {};   ///< metres to what it looks at, where that is known
  std::optional<double> take_time = {};  ///< seconds of the take, where the film says what it shows
};

/// Which times of a path have cameras: those of the film's pictures, or the path's end as well.
enum class FilmTimes { Pictures, WithEnd };

/// Of a path, `rate` a second from the film's start. Keys that follow are seen from `subject`.
std::vector<FilmCamera> film_cameras(const CameraPath& path, double rate, const SubjectTrack& subject,
                                     FilmTimes times);

/// The path that goes through all of them: a key each. A camera whose distance is not known looks at what is
/// nearest to the world's origin, a tenth of a metre away at least.
CameraPath path_through(const std::vector<FilmCamera>& cameras);

}  // namespace floatstage::pipeline
