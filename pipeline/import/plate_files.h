#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "calib/rig_formats.h"
#include "core/result.h"
#include "core/rig.h"
#include "pipeline/import/media_files.h"

namespace floatstage::pipeline {

/// Others' photographs of the empty stage, which become the take's clean plates: named as the pictures are,
/// of each camera one, a folder of them, or a video.
class PlateFiles {
 public:
  /// NotFound when no camera of `foreign` has any.
  static Result<PlateFiles> find(const std::filesystem::path& folder, const calib::ForeignRig& foreign);

  /// Serials of cameras that have none.
  const std::vector<std::string>& without() const { return without_; }

  /// Writes a camera's plates into a take: plates/<serial>.png, or of several up to 16, evenly spread from
  /// the first to the last, plates/<serial>/<number>.png. BadData for a plate of another size than the
  /// camera's pictures. Nothing for a camera that has none. Different cameras at once are fine.
  Result<void> save(std::size_t camera, const RigCamera& rig_camera, const std::filesystem::path& take) const;

 private:
  std::vector<CameraMedia> cameras_;
  std::vector<std::string> without_;
};

}  // namespace floatstage::pipeline
