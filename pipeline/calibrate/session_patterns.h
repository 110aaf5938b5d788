#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "pipeline/calibrate/session.h"

namespace floatstage::pipeline {

/// The word in a path that stands for a camera's serial.
inline constexpr std::string_view kSerialWord = "{serial}";

/// Whether a path of a session stands for several: it has '*', '?' or the word {serial}.
bool is_pattern(const std::filesystem::path& path);

/// Whether a camera of a session stands for several: a path of it has the word {serial}.
bool is_camera_pattern(const SessionCamera& camera);

/// Whether a name fits a pattern ('*': any characters, '?': one, {serial}: those that a serial may have, as
/// few as fit, the same wherever the word stands), and the serial that it then has (empty without the word).
std::optional<std::string> fit(std::string_view pattern, std::string_view name);

/// Puts what lies on the disk in the place of patterns: a camera a serial, in natural order, and the files in
/// natural order. Names that begin with '.' fit only patterns that do. A path that is there as it is written
/// is no pattern. NotFound names the pattern that nothing fits; BadData two videos of one camera, and a
/// camera that stands there twice.
Result<void> expand_patterns(Session& session);

}  // namespace floatstage::pipeline
