#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "core/mesh.h"
#include "core/result.h"

namespace floatstage {

/// A mesh with a colour for each vertex, 8-bit sRGB as photographs have it. No colours: none are written.
struct ColoredMesh {
  Mesh mesh;
  std::vector<std::array<std::uint8_t, 3>> colors;
};

/// Which axis points upwards in the file: y is what glTF says and its readers turn for, z is what our world
/// has, for programs that take coordinates as they stand.
enum class GlbUp { Y, Z };

/// Meshes one after the other as one GLB: each is a node, and an animation shows one at a time by their
/// scales (0 or 1, in steps), `frame_rate` a second. Colours are unlit (KHR_materials_unlit): photographs
/// have their light in them. A single mesh has no animation. An empty mesh is a node without one. Written to
/// a temporary name and renamed. InvalidArgument for more than 4 GiB, which a GLB cannot hold; Io.
Result<void> save_glb(std::span<const ColoredMesh> frames, double frame_rate, GlbUp up,
                      const std::filesystem::path& file);

}  // namespace floatstage
