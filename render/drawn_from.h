#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "core/frame.h"
#include "core/mesh.h"
#include "core/rig.h"
#include "core/view.h"

namespace floatstage::render {

/// All photographs that a picture of this view is made from with `count` of them blended: those, and the ones
/// that stand in where none of them sees the proxy; indices into rig.cameras, strongest first. A scene of
/// these photographs alone gives the view of the scene of all, bit by bit, where each of them has a picture.
/// What needed_cameras() names are the first of them. Any thread.
std::vector<int> drawn_from(const Rig& rig, const Mesh& mesh, const View& view, int count);

/// The parts of a camera's photograph that the native back-end reads for these views with `method`, in cells
/// of 16 px: a scene of pictures that are anything else everywhere else gives the views of the scene of whole
/// photographs, bit by bit. All of it for methods that look beyond the proxy, and where the proxy reaches
/// behind the camera. Never none. Any thread.
std::vector<PixelBox> parts_drawn_from(const RigCamera& camera, const Mesh& mesh, std::span<const View> views,
                                       std::string_view method);

}  // namespace floatstage::render
