#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

namespace floatstage::pipeline {

/// Numbers of an accessor, element after element.
struct GltfNumbers {
  std::vector<double> values;
  std::size_t width = 1;  ///< of an element
};

/// A glTF 2.0 that was opened: its document and what its accessors hold. Not a public header, since it names
/// nlohmann-json. All of it throws std::invalid_argument, or a json::exception, with what is wrong.
class GltfFile {
 public:
  /// `bytes` are a .glb's or a .gltf's; they outlive this. Buffers in files of their own lie in `folder`
  /// itself.
  GltfFile(std::string_view bytes, std::string_view name, std::filesystem::path folder);

  const nlohmann::json& document() const { return document_; }
  /// A list of the document; empty where there is none.
  const nlohmann::json& list(const char* key) const;
  /// Of floats, or of whole numbers that stand for −1 … 1 or 0 … 1. All are finite.
  GltfNumbers numbers(std::size_t accessor) const;

 private:
  std::string_view buffer(std::size_t index) const;

  std::string_view chunk_;  // of a .glb
  std::filesystem::path folder_;
  nlohmann::json document_;
  mutable std::vector<std::string> buffers_;  // that were read or decoded, by index; empty: not yet
};

}  // namespace floatstage::pipeline
