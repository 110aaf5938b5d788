#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/frame.h"
#include "core/matte.h"
#include "core/mesh.h"
#include "core/result.h"
#include "core/rig.h"
#include "core/view.h"

namespace floatstage {

/// Where the cameras of the embedded studio stand.
enum class RigShape { Ring, QuarterDome };

struct SyntheticRigOptions {
  RigShape shape = RigShape::Ring;
  int cameras = 8;
  int width = 640, height = 480;  ///< px
  double distance = 3.0;          ///< metres from the performer's axis
  double height_above_floor = 1.3;
};

/// A rig around the performer, z up, floor at z = 0, all cameras looking at the middle of the performer.
Rig synthetic_rig(const SyntheticRigOptions& options);

/// What is wrong with this studio, each with a number; all zero is the perfect studio.
struct Defects {
  double noise = 0;              ///< standard deviation of sensor noise, in 8-bit steps
  double lens_k1 = 0;            ///< Brown-Conrady k1 (k2 = -k1/4) that every camera gets
  double color_gain = 0;         ///< relative standard deviation of per-camera, per-channel gain
  double calibration_error = 0;  ///< px: standard deviation by which the *published* rig's projections are off
  double green_spill = 0;        ///< 0…1: how much green light the cloth throws on the performer
  double dropped_frames = 0;     ///< fraction of frames lost, per camera
  double time_jitter = 0;        ///< seconds: standard deviation of each exposure's start
};

struct StudioOptions {
  std::uint64_t seed = 1;
  double frame_rate = 25;  ///< of the instants that `frame` numbers
  int samples = 16;        ///< rays a pixel (a square number): partial coverage is their mean
  bool green_room = true;  ///< false: a black stage
  Defects defects = {};
};

/// One photograph and its exact truth, all in the camera's own (distorted) pixels.
struct SyntheticShot {
  Frame frame;               ///< Rgb8; status Lost and no pixels when the defect dropped it
  Matte matte;               ///< partial coverage included
  std::vector<float> depth;  ///< width*height, metres along z of the centre ray's first performer hit; +infinity elsewhere
};

/// The embedded studio: a room in green cloth and an articulated moving performer with fine texture (printed text,
/// stripes, a face-like pattern, thin limbs, loose strands that cover pixels only partly) and self-occlusion.
/// Deterministic: same rig, seed and time give the same bytes at any thread count. Rendered with Embree.
class SyntheticStudio {
 public:
  static Result<SyntheticStudio> create(const Rig& true_rig, const StudioOptions& options);
  SyntheticStudio(SyntheticStudio&&) noexcept;
  SyntheticStudio& operator=(SyntheticStudio&&) noexcept;
  ~SyntheticStudio();

  /// The rig that really took the pictures (with its lenses), and the one that calibration would publish (with the
  /// calibration error). They are equal when Defects::calibration_error is 0.
  const Rig& true_rig() const;
  const Rig& published_rig() const;

  /// What camera `camera` photographs at frame number `frame`. Thread safe.
  SyntheticShot shoot(int camera, int frame) const;

  /// What a perfect virtual camera would see, without sensor defects: the truth for novel views. Thread safe.
  SyntheticShot shoot_view(const View& view, int frame) const;

  /// A picture of the room without the performer: the clean plate.
  Image plate(int camera) const;

  /// The performer's surface at frame number `frame`: closed, outward-oriented shells (strands not included).
  Mesh performer(int frame) const;

 private:
  struct Impl;
  explicit SyntheticStudio(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace floatstage
