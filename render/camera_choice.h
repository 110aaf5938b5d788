#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/mesh.h"
#include "core/rig.h"
#include "core/view.h"
#include "render/short_list.h"

namespace floatstage::render {

/// At most this many cameras are listed (the shaders' weights are two RGBA textures).
inline constexpr int kMostListed = 8;

/// The photographs a view is made from, for the whole view: the per-pixel weights are refined from these.
struct CameraChoice {
  ShortList<int, kMostListed>
      listed;              ///< indices into the given cameras, nearest first; the first `chosen` are blended
  std::size_t chosen = 0;  ///< the others stand in where none of the chosen sees the proxy
  ShortList<float, kMostListed>
      fade;  ///< per listed camera: 1 at the view … 0 where the next camera would take its place
  ShortList<float, kMostListed> stand_in_fade;  ///< the same for the list as a whole
};

inline constexpr std::size_t kRankingSamples = 96;  ///< at least, of a mesh that has as many triangles
using RankingSamples = ShortList<Eigen::Vector3f, 2 * kRankingSamples>;

/// What choose_cameras() works in, kept from view to view.
struct CameraRanking {
  std::vector<double> angle;
  std::vector<int> order;
  std::vector<std::size_t> usable;
};

/// Chooses `count` cameras, and of those that are about as near as the nearest at most as many again (ADR
/// 315). Ranks cameras by the mean angle, over sample points of the proxy, between the ray to the view and
/// the ray to the camera (the angular penalty of Buehler et al. 2001). A camera's fade falls to zero as the
/// next camera outside the set comes as near: along a path, cameras come and go with weight zero. Ties go by
/// the camera's place in the world, never by its place in the rig.
///
/// `pictured` (empty: all) says which cameras have a picture: only those are listed, but the others still say
/// where a fade ends, so that a view drawn from just the cameras it needs equals one drawn from all.
CameraChoice choose_cameras(const std::vector<RigCamera>& cameras, const RankingSamples& samples,
                            const View& view, int count, const std::vector<bool>& pictured,
                            CameraRanking& memory);

/// Some corners of a mesh, spread over it: what cameras are ranked by.
RankingSamples ranking_samples(const Mesh& mesh);

}  // namespace floatstage::render
