#pragma once

#include <memory>

#include "core/camera.h"
#include "core/matte.h"
#include "core/silhouette.h"

namespace floatstage::recon {

struct SilhouetteOptions {
  double tolerance = 0.5;       ///< px: how far the polygon may leave the iso-line; 0 keeps every point
  bool unknown_beyond = false;  ///< outside the picture is unknown even where the subject is not cut
  double smallest = 0;          ///< px²: islands and holes of less area are left out
  int most_points = 20000;      ///< a noisier matte is made coarser until its outline has no more
};

/// How coarse an outline had to be made: what was asked for, or more.
struct OutlineDetail {
  double tolerance = 0;  ///< px
  double smallest = 0;   ///< px²
  bool coarser = false;  ///< than asked for
  bool torn = false;     ///< without the lens it crossed itself so badly that its polygons lost their meaning
};

/// Memory for one outline at a time, and what depends on its camera's calibration only. Kept from frame to
/// frame, it makes later frames allocate nothing; results do not depend on it.
class OutlineWorkspace {
 public:
  OutlineWorkspace();
  OutlineWorkspace(OutlineWorkspace&&) noexcept;
  OutlineWorkspace& operator=(OutlineWorkspace&&) noexcept;
  ~OutlineWorkspace();
  struct Impl;
  Impl& impl() { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

/// The outline of a matte (half opacity), in the picture's own, distorted pixels: what visual_hull() takes in
/// the matte's place, and finds the same hull from. Chords are as short as the camera's lens asks for, so
/// that they are straight without it too. A matte of noise is made coarser until options.most_points are
/// enough, which is returned. Without a matte, and where all of it is subject, there are no points: such a
/// camera knows nothing.
OutlineDetail outline_of(const Matte& matte, const CameraModel& model, const SilhouetteOptions& options,
                         OutlineWorkspace& workspace, Silhouette& out);
Silhouette outline_of(const Matte& matte, const CameraModel& model, const SilhouetteOptions& options = {});

/// The other way: 255 where a pixel's centre is inside, else 0. The matte is empty for an outline that knows
/// nothing, and all subject for one without points and with beyond_counts.
Matte filled(const Silhouette& outline, int width, int height);

}  // namespace floatstage::recon
