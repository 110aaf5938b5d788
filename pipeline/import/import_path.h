#pragma once

#include <filesystem>
#include <string>

#include "core/result.h"
#include "pipeline/camera_path.h"

namespace floatstage::pipeline {

struct ImportPathOptions {
  std::filesystem::path from;  ///< a .gltf or .glb, or a folder with a model of COLMAP
  double frame_rate = 25;      ///< images a second, of COLMAP: in the natural order of their names
  bool z_up = false;           ///< of glTF: coordinates stay as they are
  std::string camera = {};     ///< of glTF: a name, where several are animated
};

/// The path through another program's cameras, a key each (gltf_camera.h). What a path cannot hold of
/// COLMAP's (lens, principal point, pixels that are not square) is logged. Errors of the readers;
/// InvalidArgument for one camera only.
Result<CameraPath> import_path(const ImportPathOptions& options);

}  // namespace floatstage::pipeline
