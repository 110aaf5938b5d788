#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "pipeline/film_cameras.h"

namespace floatstage::pipeline {

/// The animated camera of a glTF 2.0 (.gltf or .glb, whose `bytes` these are; buffers beside it lie in
/// `folder`), at the times of its keys and so densely between them that straight lines will do. Nodes above
/// it move it too. Its y is up, or with `z_up` coordinates stay as they are. `camera` is a node's or a
/// camera's name; empty: the only one that is animated. NotFound where there is none or no such;
/// InvalidArgument names those to choose from; BadData for what is cut short or makes no sense; Unsupported
/// for orthographic and sheared cameras.
Result<std::vector<FilmCamera>> parse_gltf_camera(std::string_view bytes, std::string_view name_for_errors,
                                                  const std::filesystem::path& folder, bool z_up,
                                                  std::string_view camera);

}  // namespace floatstage::pipeline
