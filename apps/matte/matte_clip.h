#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "core/result.h"

namespace floatstage::apps {

/// What `matte` is told of a clip, beside --guide.
struct ClipFlags {
  std::filesystem::path out;
  std::vector<std::string> labels;  ///< "woman=mask.png"
  std::vector<std::string> clicks;  ///< of a take: "woman@cam00:12:310,200"; of a clip: "woman@12:310,200"
  std::filesystem::path edits;      ///< of a clip: strokes
};

void add_clip_flags(CLI::App& verb, ClipFlags& clip);

/// Whether `media` is a video or a folder of pictures that is to be matted as a clip, and no take.
/// InvalidArgument for a take with a clip's flags, and for a clip without --out.
Result<bool> is_clip(const std::filesystem::path& media, const std::filesystem::path& guide,
                     const ClipFlags& flags);

/// `matte` of a clip: `guide` (empty, or the masks of the label "subject"), labels and strokes. BadData,
/// after everything is written, when mattes cannot be trusted; else as pipeline::matte_clip().
Result<void> matte_clip(const std::filesystem::path& media, const std::filesystem::path& guide,
                        const ClipFlags& flags, const std::filesystem::path& json);

}  // namespace floatstage::apps
