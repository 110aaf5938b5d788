#pragma once

#include <vector>

#include "core/view.h"
#include "render/camera_ranking.h"
#include "render/short_list.h"

namespace floatstage::render {

/// At most this many cameras are listed (the shaders' weights are two RGBA textures).
inline constexpr int kMostListed = 8;

/// The photographs a view is made from, for the whole view: the per-pixel weights are refined from these.
struct CameraChoice {
  ShortList<int, kMostListed>
      listed;              ///< indices into the given cameras, nearest first; the first `chosen` are blended
  std::size_t chosen = 0;  ///< the others stand in where none of the chosen sees the proxy
  double lacking = 0;      ///< how much of what the view shows, of 1, lies beyond the chosen ones' pictures
  ShortList<float, kMostListed>
      fade;  ///< per listed camera: 1 at the view … 0 where the next camera would take its place
  ShortList<float, kMostListed> stand_in_fade;  ///< the same for the list as a whole
};

/// Chooses `count` cameras, and of those that are about as near as the nearest at most as many again (ADR
/// 315), by the ranking. A camera's fade falls to zero as the next camera outside the set comes as near:
/// along a path, cameras come and go with weight zero. Ties go by the camera's place in the world, never by
/// its place in the rig.
///
/// Those that stand in are the next ones, or, where parts of the proxy lie beyond the chosen ones' pictures,
/// those that have these parts (ADR 362).
///
/// `pictured` (empty: all) says which cameras have a picture: only those are listed, but the others still say
/// where a fade ends, so that a view drawn from just the cameras it needs equals one drawn from all.
CameraChoice choose_cameras(CameraRanking& ranking, const View& view, int count,
                            const std::vector<bool>& pictured);

}  // namespace floatstage::render
