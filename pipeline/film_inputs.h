#pragma once

#include <string>
#include <vector>

#include "capture/take.h"
#include "core/result.h"
#include "pipeline/film.h"

namespace floatstage::pipeline {

/// What a film is made from, as SHA-256: two films of the same hashes have the same pictures.

/// Of what is the same for all its pictures: the recording, the cameras with their colours, the path, every
/// option that shows, `drawn_by` (program and back-end, with OpenGL the GPU) and which cloth's cast is taken
/// off. `options` has its `rig` and `subject`. Errors: those of the take's records.
Result<std::string> hash_of_film(const capture::TakeReader& take, const CameraPath& path,
                                 const FilmOptions& options, const std::string& drawn_by);

/// Of the meshes and mattes of these frames of the take. Io.
Result<std::string> hash_of_scenes(const capture::TakeReader& take, const std::vector<int>& frames);

}  // namespace floatstage::pipeline
