#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/result.h"

namespace floatstage::pipeline {

/// Serials and pictures: BadData when hardly one of them shows what another one shows, too; errors of
/// pictures name their file. Of more than six some neighbours are asked.
Result<void> check_one_scene(const std::vector<std::pair<std::string, std::filesystem::path>>& pictures,
                             double contrast);

/// Serials and pictures in one folder, in their order: are they one clip of a camera that moves? Then some of
/// them, spread evenly, stay, and the sentence says so; otherwise they are left as they are. BadData where
/// the camera of a clip hardly left its place, which tells nothing of where it was; errors of pictures name
/// their file.
Result<std::optional<std::string>> thin_out_clip(
    std::vector<std::pair<std::string, std::filesystem::path>>& pictures, double contrast);

}  // namespace floatstage::pipeline
