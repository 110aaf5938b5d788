#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/result.h"
#include "pipeline/label_record.h"
#include "pipeline/matte/matte_clip.h"

namespace floatstage::apps {

/// A word "NAME=PATH".
struct NamedPath {
  std::string name;
  std::filesystem::path path;
};

/// What --label says. InvalidArgument for a word without a name or a path.
Result<std::vector<NamedPath>> named_paths(const std::vector<std::string>& words);

/// What --label-click says: NAME@SERIAL:FRAME:X,Y. InvalidArgument for any other word.
Result<std::vector<pipeline::LabelClick>> label_clicks(const std::vector<std::string>& words);
/// The same of a clip, which has one camera: NAME@FRAME:X,Y.
Result<std::vector<pipeline::ClipClick>> clip_clicks(const std::vector<std::string>& words);

}  // namespace floatstage::apps
