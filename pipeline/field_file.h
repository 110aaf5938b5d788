#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "render/camera_fields.h"

namespace floatstage::pipeline {

/// fields/<serial>/<frame>.fields of a take: the fields of one camera to others at one instant, and what they
/// were made from (render::FieldInputs). docs/formats.md has the bytes.
struct FieldFile {
  struct Neighbor {
    std::string serial;
    std::string made_from;  ///< hash of that camera
    std::vector<std::int16_t> uv;
    bool operator==(const Neighbor&) const = default;
  };
  render::FlowOptions flow;
  std::string mesh, camera;  ///< hashes of the mesh and of the camera itself
  std::array<float, 4> place{};
  int width = 0, height = 0;
  std::vector<Neighbor> neighbors;
  bool operator==(const FieldFile&) const = default;
};

/// BadData names the file: it is none, was cut off, has something behind its end, or was damaged.
Result<FieldFile> decode_fields(std::string_view bytes, std::string_view name_for_errors);
std::string encode_fields(const FieldFile& fields);

/// NotFound, Io, BadData.
Result<FieldFile> load_field_file(const std::filesystem::path& file);
/// Whole or not at all. Io.
Result<void> save_field_file(const FieldFile& fields, const std::filesystem::path& file);

}  // namespace floatstage::pipeline
