#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>
#include <embree3/rtcore.h>

#include "core/synthetic/performer.h"

namespace floatstage::synthetic {

struct ReleaseDevice {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
};
struct ReleaseScene {
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
using Device = std::unique_ptr<RTCDeviceTy, ReleaseDevice>;

inline constexpr int kPacket = 8;
inline constexpr std::uint32_t kMiss = RTC_INVALID_GEOMETRY_ID;

/// Where a ray met the performer: triangle, barycentric weights of its second and third vertex, ray
/// parameter, and the cosine between the ray and the triangle's normal.
struct Hit {
  std::uint32_t triangle = kMiss;
  float u = 0, v = 0, t = 0, cosine = 1;
};

/// The performer at one instant, lit and ready to be photographed. Read-only after construction, so thread
/// safe.
///
/// The light is a fixed dome of lamps whose shadows are traced per vertex (Lambert): soft, and the same from
/// every viewpoint, as the photographs of many cameras must be for image-based rendering.
class StageScene {
 public:
  StageScene(RTCDevice device, const Performer& performer, double seconds);

  const Performer& performer() const { return *performer_; }
  const std::vector<Eigen::Vector3f>& positions() const { return positions_; }

  /// Traces up to kPacket rays from one origin.
  void intersect(const Eigen::Vector3f& origin, const std::array<Eigen::Vector3f, kPacket>& directions,
                 int count, std::array<Hit, kPacket>& hits) const;

  /// Colour of a hit (gamma space, may exceed 1 a little). `footprint` in metres across the ray; `spill` 0…1
  /// of the cloth's green light.
  Eigen::Vector3f shade(const Hit& hit, float footprint, float spill, std::uint32_t seed,
                        Dress dress = Dress::Usual) const;

 private:
  void light_vertices(const std::vector<Eigen::Vector3f>& normals);
  void light_hidden_vertices();

  const Performer* performer_;
  std::vector<Eigen::Vector3f> positions_;
  std::vector<float> light_, cloth_;  ///< per vertex: lamp light, and light that comes by way of the cloth
  std::vector<float> openness_;       ///< per vertex: share of the sky over it that it sees
  std::unique_ptr<RTCSceneTy, ReleaseScene> scene_;
};

}  // namespace floatstage::synthetic
