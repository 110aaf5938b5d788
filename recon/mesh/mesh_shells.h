#pragma once

#include <cstdint>
#include <vector>

#include "core/mesh.h"
#include "core/rig.h"
#include "recon/hull_input.h"
#include "recon/stage_volume.h"
#include "recon/visual_hull.h"

namespace floatstage::recon {

/// Which shells (components connected through common vertices) of a hull are worth keeping.
struct ShellRules {
  const StageFinder* stage =
      nullptr;      ///< shells with no vertex in one of its cubes are not hull; null: all are
  int cameras = 0;  ///< shells of which fewer cameras see any vertex are not hull: nothing bears witness
  /// px: a shell is a crumb when moving every outline inwards by so much would leave nothing of it. 0: none.
  double uncertainty = 0;
};

/// What was left out.
struct ShellCount {
  int crumbs = 0;
  double crumb_volume = 0;  ///< m³, of all crumbs
};

/// Takes shells out of a hull. Keeps its memory: a later frame of the same size allocates nothing.
class ShellFilter {
 public:
  /// A body's largest inner ball has a radius of at most 3 V / A if it is convex; seen by the camera to which
  /// it is smallest, that is what an outline may move before it is gone. The shell with the largest volume is
  /// no crumb, and a cavity goes when the shells around it have gone. Sources follow the triangles.
  ShellCount apply(const Rig& rig, const HullInput& input, const ShellRules& rules, Mesh& mesh,
                   std::vector<HullFaceSource>& sources);

 private:
  struct Shell {
    double volume = 0, area = 0;
    Eigen::AlignedBox3d box;
    int witnesses = 0;  ///< the most cameras that see one of its vertices
    bool within = false;
    bool keep = true;
  };

  std::uint32_t root_of(std::uint32_t vertex);
  void find_shells(const Mesh& mesh);
  void count_witnesses(const Rig& rig, const HullInput& input, const Mesh& mesh, int enough);
  void keep_those_within(const StageFinder& stage, const Mesh& mesh);
  void drop_orphaned_cavities();
  void compact(Mesh& mesh, std::vector<HullFaceSource>& sources);

  std::vector<std::uint32_t> root_;
  std::vector<int> shell_of_;  ///< per vertex; -1: of no triangle
  std::vector<Shell> shells_;
};

}  // namespace floatstage::recon
