#pragma once

#include <functional>

#include <Eigen/Core>

#include "core/camera.h"
#include "core/image.h"
#include "core/mesh.h"

namespace floatstage {

struct Photograph {
  Image rgb;    ///< 3 channels
  Image alpha;  ///< 1 channel: coverage
};

/// Colours (0…255) by place in the world.
using SolidColor = std::function<Eigen::Vector3f(const Eigen::Vector3f& world)>;

/// What a camera would see of a mesh painted all through, as truth to compare renderers with: slow and exact,
/// `samples` x `samples` rays a pixel, by a z-buffer that shares no code with the renderers. Lenses are
/// honoured per sample. Off the mesh: `background`. One thread; any number of them at once.
Photograph photograph(const Mesh& mesh, const CameraModel& model, const Rigid3& cam_from_world, int samples,
                      const SolidColor& color, const Eigen::Vector3f& background = Eigen::Vector3f::Zero());

/// A solid checker: one random colour a cell of this size (metres).
SolidColor random_checker(float cell, std::uint64_t seed);

}  // namespace floatstage
