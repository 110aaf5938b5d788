#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include <Eigen/Core>

#include "core/camera.h"
#include "core/image.h"
#include "core/synthetic/room.h"
#include "core/synthetic/stage_scene.h"

namespace floatstage::synthetic {

/// A camera prepared for tracing: the ray through every pixel corner, lens included. Between corners rays are
/// interpolated, which is exact for a pinhole and good to a thousandth of a pixel for any sane lens.
class TracingCamera {
 public:
  TracingCamera(const CameraModel& model, const Rigid3& cam_from_world);

  const CameraModel& model() const { return model_; }
  const Rigid3& cam_from_world() const { return cam_from_world_; }
  const Eigen::Vector3f& center() const { return center_; }

  /// World direction, with z = 1 along the optical axis: ray parameters are depths. NaN where the lens has no
  /// ray. (sx, sy) in [0, 1]² is the place in the pixel.
  Eigen::Vector3f direction(int x, int y, float sx, float sy) const;

 private:
  CameraModel model_;
  Rigid3 cam_from_world_;
  Eigen::Vector3f center_;
  Eigen::Matrix3f world_from_cam_;
  std::vector<Eigen::Vector2f> corners_;  ///< (width + 1) * (height + 1)
};

/// What the sensor would collect, before its defects.
struct Exposure {
  int width = 0, height = 0;
  std::vector<Eigen::Vector3f> color;  ///< gamma space, 0…1
  std::vector<std::uint8_t> alpha;
  std::vector<float> depth;                              ///< metres; +infinity off the performer
  std::vector<std::vector<std::uint8_t>> alpha_of = {};  ///< of each performer, where there are two
};

struct PhotographOptions {
  int samples_across = 4;  ///< rays a pixel = samples_across²
  float spill = 0;
  Dress dress = Dress::Usual;
  std::uint32_t seed = 1;
  std::function<bool()> stop = {};  ///< asked now and then; once it says yes, what is left is left out
};

/// The empty room as the camera sees it.
Image photograph_room(const TracingCamera& camera, const Room& room, const std::function<bool()>& stop = {});

/// The performer before `plate`: colour = alpha * mean performer colour + (1 - alpha) * plate.
Exposure photograph(const TracingCamera& camera, const StageScene& scene, const Image& plate,
                    const PhotographOptions& options);

}  // namespace floatstage::synthetic
