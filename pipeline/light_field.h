#pragma once

#include <optional>
#include <vector>

#include "capture/take.h"
#include "core/image.h"
#include "core/mesh.h"
#include "core/result.h"
#include "core/rig.h"

namespace floatstage::pipeline {

/// A plane `distance` metres before the cameras' mean place, across their mean viewing direction, as far as
/// any camera sees it; in pieces, so that its corners are spread over it. InvalidArgument for a plane that is
/// not before all cameras.
Result<Mesh> plane_before(const Rig& rig, double distance);

/// The distance at which what neighbouring cameras of a grid show through the plane differs least (squared,
/// on pictures of a quarter of the size): the plane that blends them best, as that of Eq. 9.13 does for a
/// scene whose depths are evenly spread in disparity. `pictures` are RGB or empty, one a camera.
/// InvalidArgument where the cameras stand on no grid or two neighbours have no picture.
Result<double> plane_of_pictures(const Rig& rig, const std::vector<Image>& pictures);

/// Gives every frame of a take of a light field its proxy, meshes/<frame>.ply: the plane at `distance`, or
/// where the pictures of the first frame say. Returns the distance. Errors of the above, Io.
Result<double> give_plane(capture::TakeReader& take, std::optional<double> distance);

}  // namespace floatstage::pipeline
