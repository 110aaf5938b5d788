#pragma once

#include "core/mesh.h"

namespace floatstage::pipeline {

/// The same surface in triangles whose sides are no longer than `longest` (metres, above 0): every longer
/// side is halved, for both of its triangles at once, until none is left. A closed mesh stays closed.
Mesh refined(Mesh mesh, double longest);

}  // namespace floatstage::pipeline
