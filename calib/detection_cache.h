#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "calib/detect.h"

namespace floatstage::calib {

/// Detections on disk: one small text file a picture, named by the picture's key, the target and the options.
/// Thread safe: files are written whole or not at all. Private to calib.
class DetectionCache {
 public:
  DetectionCache(std::filesystem::path folder, const TargetDesign& design, const DetectOptions& options);

  std::optional<Detection> find(const std::string& key) const;
  void store(const std::string& key, const Detection& detection) const;

 private:
  std::filesystem::path file(const std::string& key) const;

  std::filesystem::path folder_;
  std::string about_;  ///< all that the result depends on but the picture
};

}  // namespace floatstage::calib
