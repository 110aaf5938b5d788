#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "calib/silhouettes/silhouette_turn.h"
#include "core/matte.h"
#include "core/rig.h"
#include "core/silhouette.h"
#include "pipeline/progress.h"
#include "pipeline/silhouettes/camera_groups.h"
#include "recon/mesh/mesh_silhouettes.h"
#include "recon/visual_hull.h"

namespace floatstage::pipeline {

/// One instant of a take: mattes[i] belongs to rig.cameras[i]; an empty one says nothing.
using InstantMattes = std::vector<Matte>;

/// How hulls that silhouettes are measured with are made: fine outlines, nothing dropped, one thread.
/// `quality`: with the silhouettes' IoU.
recon::HullOptions silhouette_hull_options(bool quality);

/// Each camera's silhouettes against hulls that the camera had no part in, for any rig of the same cameras.
/// The instants are only read and must outlive it. Safe for concurrent use.
class LeftOutHulls {
 public:
  /// `quick`: from large groups and fewer points of the outlines: good enough to tell who has turned.
  /// threads: 0 for one per core; results are the same at any number. progress may be null.
  LeftOutHulls(const Rig& rig, const std::vector<InstantMattes>& instants, bool quick, int threads,
               Progress* progress);

  /// Of one camera, against hulls of all others: what is measured best; quickly, of those of other groups,
  /// which are kept while these stand as they did.
  calib::SilhouetteTurn turn_of(const Rig& rig, std::size_t camera) const;

  /// Of every camera, against a few hulls (CameraGroups); unknown where the run was cancelled.
  std::vector<calib::SilhouetteTurn> turns_of(const Rig& rig) const;

  /// Mean IoU of all cameras' hull with the mattes; absent where no instant has a hull.
  std::optional<double> iou_of(const Rig& rig) const;

 private:
  using Hulls = std::vector<recon::MeshSilhouettes>;  // by instant
  struct GroupHulls {
    std::vector<Rigid3> poses;  // of the cameras that had a part in them
    Hulls hulls;
  };

  std::vector<Rigid3> poses_without(const Rig& rig, std::size_t group) const;
  /// Hulls without these groups, made or, quickly, kept. Those that are made take turns with `progress`.
  std::vector<std::shared_ptr<const GroupHulls>> hulls_of(const Rig& rig,
                                                          const std::vector<std::size_t>& groups,
                                                          ProgressPart* progress) const;
  /// Of the cameras that are not `left_out(camera)`. Empty where there is none.
  template <class Left>
  recon::MeshSilhouettes hull_without(const Rig& rig, std::size_t instant, const Left& left_out) const;
  calib::SilhouetteTurn turn_against(const Rig& rig, std::size_t camera, const Hulls& hulls) const;

  const std::vector<InstantMattes>& instants_;
  bool quick_;
  int threads_;
  Progress* progress_;
  CameraGroups groups_;
  std::vector<std::vector<Silhouette>> own_;
  mutable std::mutex mutex_;
  mutable std::vector<std::shared_ptr<const GroupHulls>> kept_;  // by group
};

}  // namespace floatstage::pipeline
