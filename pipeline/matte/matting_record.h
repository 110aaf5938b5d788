#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "core/matte_edits.h"
#include "core/result.h"
#include "core/take_layout.h"

namespace floatstage::pipeline {

/// How one camera's mattes were made: what must not change while they are kept.
struct CameraRecord {
  std::string method;  ///< as asked for
  std::string chosen;  ///< what auto chose; else the same
  std::string key;     ///< what first told the subject
  std::string guide;   ///< the folder of others' mattes, or nothing
  std::string edits;   ///< fingerprint of the camera's part of edits.json
  std::set<int> stale =
      {};  ///< frames whose mattes are there but were made before these edits: an editor was interrupted
  bool operator==(const CameraRecord&) const = default;
};

/// mattes/matting.json, by serial. Empty when the take has not been matted by the verb `matte`.
Result<std::map<std::string, CameraRecord>> load_matting(const TakeLayout& layout);
Result<void> save_matting(const std::map<std::string, CameraRecord>& record, const TakeLayout& layout);

/// Where `spectral` keeps the matting components of a camera.
inline std::filesystem::path spectral_cache(const TakeLayout& layout, const std::string& serial) {
  return layout.mattes() / "spectral" / serial;
}

/// The same for equal edits, in hexadecimal.
std::string fingerprint(const CameraEdits& edits);

}  // namespace floatstage::pipeline
