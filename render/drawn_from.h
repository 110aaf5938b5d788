#pragma once

#include <vector>

#include "core/mesh.h"
#include "core/rig.h"
#include "core/view.h"

namespace floatstage::render {

/// All photographs that a picture of this view is made from with `count` of them blended: those, and the ones
/// that stand in where none of them sees the proxy; indices into rig.cameras, strongest first. A scene of
/// these photographs alone gives the view of the scene of all, bit by bit, where each of them has a picture.
/// What needed_cameras() names are the first `count`. Any thread.
std::vector<int> drawn_from(const Rig& rig, const Mesh& mesh, const View& view, int count);

}  // namespace floatstage::render
