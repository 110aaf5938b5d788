#pragma once

#include <filesystem>
#include <string>

#include "core/result.h"
#include "detail/transfer.h"

namespace floatstage::detail {

/// Writes every step of a transfer as a PNG, <name>-1-parent.png to <name>-8-mask.png, into a folder that is
/// there (docs/detail.md shows what each is). Io.
Result<void> save_steps(const LightPicture& child, const LightPicture& parent, const Transfer& transfer,
                        const std::filesystem::path& folder, const std::string& name);

}  // namespace floatstage::detail
