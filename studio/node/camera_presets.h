#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

#include "core/result.h"

namespace floatstage::studio {

/// Values of controls by their name, by their camera's serial.
using CameraPreset = std::map<std::string, std::map<std::string, double>>;

/// What an operator kept of the cameras' controls, by name. A TOML file of its own, since it is written by a
/// program and the studio's is written by people (ADR 283): ["name"."serial"] control = value.
using CameraPresets = std::map<std::string, CameraPreset>;

/// None where the file is not there. BadData names the file and the line; Io.
Result<CameraPresets> load_presets(const std::filesystem::path& file);
/// `file` is for the errors: BadData.
Result<CameraPresets> parse_presets(std::string_view bytes, const std::filesystem::path& file);
/// Replaces the file. Io.
Result<void> save_presets(const CameraPresets& presets, const std::filesystem::path& file);
/// 1 to 60 letters, digits, '.', '-' and '_'.
bool is_preset_name(const std::string& name);

}  // namespace floatstage::studio
