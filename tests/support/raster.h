#pragma once

#include <functional>

#include <Eigen/Core>

#include "core/camera.h"
#include "core/image.h"
#include "core/mesh.h"

namespace floatstage::test {

struct Photograph {
  Image rgb;    ///< 3 channels
  Image alpha;  ///< 1 channel: coverage
};

/// Colours (0…255) by place in the world.
using SolidColor = std::function<Eigen::Vector3f(const Eigen::Vector3f& world)>;

/// A slow exact picture of a mesh, `samples` x `samples` rays a pixel, by a z-buffer on the CPU that shares
/// no code with the renderer under test. Lenses are honoured per sample. Off the mesh: `background`.
Photograph photograph(const Mesh& mesh, const CameraModel& model, const Rigid3& cam_from_world, int samples,
                      const SolidColor& color, const Eigen::Vector3f& background = Eigen::Vector3f::Zero());

/// A solid checker: one random colour a cell of this size (metres).
SolidColor random_checker(float cell, std::uint64_t seed);

}  // namespace floatstage::test
