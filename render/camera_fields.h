#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/mesh.h"
#include "core/result.h"
#include "core/rig.h"
#include "core/view.h"
#include "render/flow.h"

namespace floatstage::render {

class Scene;
struct RendererOptions;

/// From which camera's picture to which other camera's: indices into Rig::cameras.
struct CameraPair {
  int from = 0, to = 0;
  auto operator<=>(const CameraPair&) const = default;
};

/// A flow W_{I_i -> I_j^i} (Eq. 11.4): photograph `from` looks at (x, y) like photograph `to`, carried by the
/// proxy into the same picture, at (x, y) + (u, v) * kStep. In ideal pinhole coordinates of camera `from`, so
/// that one grid serves any lens. Immutable once it is in a FieldSet.
struct CameraField {
  static constexpr float kStep = 1.F / 64;  ///< px of the grid

  std::array<float, 4> place{};  ///< px of the grid = xy * (x/z, y/z) + zw
  int width = 0, height = 0;     ///< px, multiples of 2 … kLargestSide; 0: the camera sees no proxy
  std::vector<std::int16_t> uv;  ///< 2 * width * height

  static constexpr int kLargestSide = 2048;
};

/// Fields of one instant, and how their flows were estimated.
struct FieldSet {
  FlowOptions flow;
  std::map<CameraPair, std::shared_ptr<const CameraField>> fields;
};

/// Whether both estimate the same fields, wherever they do.
bool same_fields(const FlowOptions& a, const FlowOptions& b);

/// Rounds displacements to steps; what is farther than 16 bits reach stays at their end.
std::vector<std::int16_t> to_steps(const std::vector<float>& uv);

/// The pinhole in place of a camera, over what of its picture `box` can cover, in pixels no smaller than the
/// photograph's: fields are estimated in it.
View field_view(const RigCamera& camera, const Eigen::AlignedBox3f& box);

/// What a scene's fields are made from, as content_hash(): a field between two cameras of the same hashes, on
/// a mesh of the same hash, with the same flow is the same field, byte for byte.
struct FieldInputs {
  std::string mesh;
  std::map<int, std::string> cameras;  ///< by index into the rig's: pose, lens, photograph, matte
};
FieldInputs field_inputs(const Scene& scene);

/// Estimates fields between cameras of a scene, on the CPU. Of the options count the flow, the threads and
/// who gives it up. InvalidArgument for a camera without a picture; Cancelled.
Result<FieldSet> estimate_fields(const Scene& scene, std::span<const CameraPair> pairs,
                                 const RendererOptions& options);

/// The pairs that views between cameras blend: of each camera those to its `neighbors` nearest, by the mean
/// angle at the mesh. Of cameras with `usable[i]` (empty: all). Sorted.
std::vector<CameraPair> field_pairs(const Rig& rig, const Mesh& mesh, int neighbors,
                                    const std::vector<bool>& usable = {});

}  // namespace floatstage::render
