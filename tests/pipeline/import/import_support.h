#pragma once

#include <filesystem>
#include <string>

#include "core/image.h"
#include "core/rig.h"

namespace floatstage::pipeline {

inline constexpr int kImportWidth = 32, kImportHeight = 24;

/// A picture that is different for every (camera, frame).
Image test_picture(int camera, int frame, int width = kImportWidth, int height = kImportHeight);

/// Cameras "a", "b", "c", … of kImportWidth × kImportHeight on a ring.
Rig test_rig(int cameras);

/// Writes pictures 000000.png … of one camera into a new folder.
void save_pictures(const std::filesystem::path& folder, int camera, int count);

}  // namespace floatstage::pipeline
