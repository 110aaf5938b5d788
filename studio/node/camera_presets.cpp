#include "studio/node/camera_presets.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <sstream>

#include <toml++/toml.h>

#include "core/file.h"
#include "core/text.h"

namespace floatstage::studio {
namespace {

Unexpected wrong(const std::filesystem::path& file, const toml::node& node, const std::string& what) {
  return fail(ErrorCode::BadData, text(file.string(), ", line ", node.source().begin.line, ": ", what,
                                       "; correct it, or move the file away"));
}

}  // namespace

bool is_preset_name(const std::string& name) {
  return !name.empty() && name.size() <= 60 && std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return std::isalnum(c) || c == '.' || c == '-' || c == '_';
  });
}

Result<CameraPresets> load_presets(const std::filesystem::path& file) {
  if (std::error_code ignored; !std::filesystem::exists(file, ignored)) return CameraPresets();
  const Result<std::string> bytes = read_file(file);
  if (!bytes) return forward(bytes);
  return parse_presets(*bytes, file);
}

Result<CameraPresets> parse_presets(std::string_view bytes, const std::filesystem::path& file) {
  toml::table root;
  try {
    root = toml::parse(bytes);
  } catch (const toml::parse_error& e) {
    return fail(ErrorCode::BadData, text(file.string(), ", line ", e.source().begin.line, ": no TOML: ",
                                         e.description(), "; correct it, or move the file away"));
  }
  CameraPresets presets;
  for (const auto& [name, cameras] : root) {
    if (!is_preset_name(std::string(name.str())))
      return wrong(file, cameras, "a preset's name is 1 to 60 letters, digits, '.', '-' and '_'");
    if (!cameras.is_table()) return wrong(file, cameras, "a preset is a table of cameras");
    CameraPreset& preset = presets[std::string(name.str())];
    for (const auto& [serial, controls] : *cameras.as_table()) {
      if (!controls.is_table()) return wrong(file, controls, "a camera is a table of controls");
      for (const auto& [control, value] : *controls.as_table()) {
        const std::optional<double> number = value.is_number() ? value.value<double>() : std::nullopt;
        if (!number || !std::isfinite(*number)) return wrong(file, value, "a control is a number");
        preset[std::string(serial.str())][std::string(control.str())] = *number;
      }
    }
  }
  return presets;
}

Result<void> save_presets(const CameraPresets& presets, const std::filesystem::path& file) {
  toml::table root;
  for (const auto& [name, preset] : presets) {
    toml::table cameras;
    for (const auto& [serial, controls] : preset) {
      toml::table values;
      for (const auto& [control, value] : controls) values.insert(control, value);
      cameras.insert(serial, std::move(values));
    }
    root.insert(name, std::move(cameras));
  }
  std::ostringstream out;
  out << "# Camera settings that operators kept on the node's page; written anew each time.\n\n"
      << root << "\n";
  return write_file(file, out.str());
}

}  // namespace floatstage::studio
