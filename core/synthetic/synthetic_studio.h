#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "core/frame.h"
#include "core/matte.h"
#include "core/mesh.h"
#include "core/result.h"
#include "core/rig.h"
#include "core/synthetic/stage.h"
#include "core/view.h"

namespace floatstage {

/// Where the cameras of the embedded studio stand. The performer faces +y.
enum class RigShape {
  Ring,        ///< evenly around, the first in front; from above, clockwise
  QuarterDome  ///< rows over the quarter circle in front, up to 45° of elevation; row by row from the lowest
};

struct SyntheticRigOptions {
  RigShape shape = RigShape::Ring;
  int cameras = 8;
  int width = 640, height = 480;  ///< px
  double distance = 3.0;          ///< metres from the performer's axis
  double height_above_floor = 1.3;
  SyntheticCast cast = SyntheticCast::One;  ///< pictures show all of it; two need a distance of 4 or more
};

/// A rig of pinholes around the performer, z up, floor at z = 0, all cameras looking at the middle of the
/// performer, with focal lengths that show the performer whole at all times. Serials cam00, cam01, …
Rig synthetic_rig(const SyntheticRigOptions& options);

/// What is wrong with this studio, each with a number; all zero is the perfect studio. Everything random in
/// them is addressed by (seed, camera, frame), so it does not depend on what was shot before.
struct Defects {
  double noise = 0;              ///< standard deviation of sensor noise, in 8-bit steps
  double lens_k1 = 0;            ///< Brown-Conrady k1 (k2 = -k1/4) that every camera gets
  double color_gain = 0;         ///< relative standard deviation of per-camera, per-channel gain
  double calibration_error = 0;  ///< px, r.m.s. per image axis and camera over the performer: how far the
                                 ///< *published* rig projects off
  double green_spill = 0;        ///< 0…1: how much green light the cloth throws on the performer
  double dropped_frames = 0;     ///< fraction of frames lost, per camera
  double time_jitter =
      0;  ///< seconds: standard deviation of each exposure's start; cut at 0.45 frame periods
};

struct SyntheticStudioOptions {
  std::uint64_t seed = 1;
  double frame_rate = 25;  ///< of the instants that `frame` numbers
  int samples = 16;        ///< rays a pixel (a square number up to 1024): partial coverage is their mean
  SyntheticStage stage = SyntheticStage::Green;
  SyntheticCast cast = SyntheticCast::One;
  Defects defects = {};
  /// Asked while pictures are rendered, on the threads that render; once it says yes they are left
  /// unfinished.
  std::function<bool()> stop = {};
};

/// One photograph and its exact truth, all in the camera's own (distorted) pixels. Colour is
/// alpha * performer + (1 - alpha) * plate. Of a dropped frame there is neither picture nor truth.
struct SyntheticShot {
  Frame frame;                  ///< Rgb8; status Lost and no pixels when the defect dropped it
  Matte matte;                  ///< share of the pixel's rays that meet a performer, strands included
  std::vector<Matte> matte_of;  ///< of each performer, where there are two; they add up to `matte`, ±1
  std::vector<float>
      depth;  ///< width*height, metres along z of the centre ray's first performer hit; +infinity elsewhere
};

/// The embedded studio: a room in green cloth, or another stage, and an articulated moving performer with
/// fine texture (printed text, stripes, a face-like pattern, thin limbs, loose strands that cover pixels only
/// partly) and self-occlusion. Light does not depend on the viewpoint, so all cameras see a surface point in
/// one colour. Deterministic: same rig, seed and time give the same bytes at any thread count and in any
/// order of calls. Rendered with Embree, each shot on the thread that asks for it; run shots in parallel to
/// use more cores, those of one frame one after the other: they share its scene.
class SyntheticStudio {
 public:
  /// Errors: what check(true_rig) finds; InvalidArgument naming the option or defect that is out of its
  /// range; Unsupported where Embree does not run; Cancelled. Shoots the plates, on all cores.
  static Result<SyntheticStudio> create(const Rig& true_rig, const SyntheticStudioOptions& options);
  SyntheticStudio(SyntheticStudio&&) noexcept;
  SyntheticStudio& operator=(SyntheticStudio&&) noexcept;
  ~SyntheticStudio();

  /// The rig that really took the pictures (with its lenses), and the one that calibration would publish
  /// (with the calibration error). They are equal when Defects::calibration_error is 0.
  const Rig& true_rig() const;
  const Rig& published_rig() const;

  /// What camera `camera` photographs at frame number `frame` >= 0. `exposure_start` is frame / frame_rate
  /// (and what jitter adds), on a studio clock that begins at 0; the device counter is the same clock. Thread
  /// safe.
  SyntheticShot shoot(int camera, int frame) const;

  /// What a perfect virtual camera would see: the truth for novel views. No sensor defects (noise, gain,
  /// drops, jitter); the spill stays, as it is light. Thread safe.
  SyntheticShot shoot_view(const View& view, int frame) const;

  /// A picture of the room without the performer: the clean plate, with the camera's gain, its noise averaged
  /// away.
  Image plate(int camera) const;

  /// The performer's surface at frame number `frame`: closed, outward-oriented shells that may run through
  /// one another at joints (strands not included); of two performers one after the other. Topology is the
  /// same in all frames.
  Mesh performer(int frame) const;

 private:
  struct Impl;
  explicit SyntheticStudio(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace floatstage
