#pragma once

#include <vector>

#include "calib/color_balance.h"
#include "core/image.h"
#include "core/mesh.h"
#include "core/rig.h"

namespace floatstage::calib {

/// Depth of the nearest surface, metres along z, by rows; +infinity where there is none. Triangles are taken
/// as straight in the (distorted) picture.
std::vector<float> depth_map(const Mesh& mesh, const RigCamera& camera);

/// Colours of up to `most` points of a surface, evenly spread over its triangles, in every camera that sees
/// them: from the front, away from outlines and other surfaces, and where the picture is smooth, so that a
/// millimetre more or less does not matter. images[i] (RGB) belongs to rig.cameras[i]; empty ones are passed
/// over. Points are numbered from `first_point` on.
std::vector<ColorSample> surface_colors(const Mesh& mesh, const Rig& rig, const std::vector<Image>& images,
                                        int first_point, int most = 3000);

}  // namespace floatstage::calib
