#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/result.h"
#include "pipeline/film_cameras.h"

namespace floatstage::pipeline {

/// A glTF 2.0 of one camera whose node is animated, position and rotation, in straight lines between the
/// cameras' times. glTF cannot animate a field of view: the file has the first one, and in the animation's
/// extras all of them with distances and the take's seconds, which import_path() reads. y is up, or with
/// `z_up` coordinates stay as they are. Floats, as glTF has them. Two cameras at least.
std::string to_gltf(const std::vector<FilmCamera>& cameras, bool z_up, bool binary);

/// Whether a name is one of glTF's.
bool names_a_gltf(const std::filesystem::path& file);

/// Writes cameras to `out`: a .gltf or .glb (to_gltf()), else a new folder that COLMAP 3.8 reads as a model:
/// cameras, images (frame_000000.png …, one a camera) and points3D, as .txt and .bin, of pictures of this
/// size. InvalidArgument for fewer than two cameras; AlreadyExists; Io. Whole or not at all.
Result<void> export_path(const std::vector<FilmCamera>& cameras, int width, int height, bool z_up,
                         const std::filesystem::path& out);

}  // namespace floatstage::pipeline
