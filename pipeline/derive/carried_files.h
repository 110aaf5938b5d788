#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "capture/take.h"
#include "core/result.h"
#include "pipeline/derive/derived_take.h"

namespace floatstage::pipeline {

// What new takes of old ones take over as it lies.

/// The same file under a second name; a copy where there can be none. `report` counts the bytes. Io.
Result<void> share(const std::filesystem::path& from, const std::filesystem::path& to, DerivedReport& report);
/// The same where there is such a file; the folder that it goes to is made.
Result<void> share_if_there(const std::filesystem::path& from, const std::filesystem::path& to,
                            DerivedReport& report);
/// Everything below a folder, as it lies. Nothing of ours is written in place, so that links stay true.
Result<void> share_folder(const std::filesystem::path& from, const std::filesystem::path& to,
                          DerivedReport& report);
/// A take's sound tracks. Their times are those of the take's clock, which a part keeps.
Result<void> share_sound(const capture::TakeReader& take, const TakeLayout& to, DerivedReport& report);

/// What pictures of these takes (one at least) are written again with, without losing anything; says so where
/// they had lost something before.
capture::TakeCodec lossless_codec(std::span<const std::unique_ptr<capture::TakeReader>> takes,
                                  std::vector<std::string>& notes);

}  // namespace floatstage::pipeline
