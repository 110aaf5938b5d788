#pragma once

#include <string>

#include "core/result.h"
#include "studio/messages/message.h"
#include "studio/messages/studio_scene.h"

namespace floatstage::studio::wire {

inline constexpr std::size_t kMostVertices = 1 << 21, kMostTriangles = 1 << 22, kMostCameras = 1024;

/// A scene: positions as they are (three floats), corners of triangles as 16 bits where that is enough.
/// InvalidArgument for a mesh that cannot travel: too large, not finite, or with corners that are not there.
Result<std::string> encode_scene(const StudioScene& scene);

/// BadData when it makes no sense; each corner of each triangle is one of the positions, which are finite.
Result<StudioScene> decode_scene(const Message& message);

}  // namespace floatstage::studio::wire
