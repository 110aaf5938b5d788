#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "recon/exact/exact_views.h"
#include "recon/hull_input.h"
#include "recon/silhouette.h"

namespace floatstage::recon {

struct ConeOptions {
  double tolerance = 0.5;  ///< px, of the contours; 0 leaves outlines that were given as they are
  std::optional<Eigen::AlignedBox3d> volume;  ///< the hull is sought here
  /// Per camera: 1 where a part of the body may lie outside the picture, so that what is beyond is unknown;
  /// empty: where the picture does not hold all of the volume.
  std::span<const std::uint8_t> partial;
  double smallest = 0;      ///< px²: islands and holes of less area are left out
  int most_points = 20000;  ///< contour points of one view; noisier mattes are made coarser
  int threads = 1;
};

/// The silhouettes of one instant as cones. Cameras without a matte, and those whose matte is all subject,
/// know nothing and have no cone.
struct SilhouetteCones {
  std::vector<Silhouette> outlines;  ///< per camera of the rig: undistorted px; empty where it knows nothing
  std::vector<OutlineDetail> details;  ///< per camera of the rig
  std::vector<ConeView> views;         ///< then the volume's, when there is one
  std::vector<int> camera;             ///< per view: index into the rig; -1 for the volume
  double pixel = 1e-3;                 ///< smallest 1 / focal length
};

class ConeBuilder {
 public:
  void build(const Rig& rig, const HullInput& input, const ConeOptions& options, SilhouetteCones& out);

 private:
  /// What depends on the calibration only; made again when a camera's model changes.
  struct CameraTable {
    CameraModel model;
    double bend = 0;
  };
  std::vector<CameraTable> tables_;
  std::vector<SilhouetteScratch> scratch_;
};

/// Appends the two far views that bound `box`.
void add_volume(const Eigen::AlignedBox3d& box, SilhouetteCones& cones);

}  // namespace floatstage::recon
