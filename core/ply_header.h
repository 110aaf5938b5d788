#pragma once

// Private to core: what a PLY file says that it holds.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"

namespace floatstage {

enum class PlyFormat { Ascii, LittleEndian, BigEndian };
enum class PlyType { Int8, UInt8, Int16, UInt16, Int32, UInt32, Float32, Float64 };

std::size_t size_of(PlyType type);

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::Float32;      ///< of the value, or of each item of a list
  PlyType count_type = PlyType::UInt8;  ///< of the length of a list
  bool is_list = false;
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
};

struct PlyHeader {
  PlyFormat format = PlyFormat::Ascii;
  std::vector<PlyElement> elements;  ///< in the file's order
  std::size_t size_bytes = 0;        ///< where the data begins
};

/// Reads the header, lines ending in \n or \r\n. BadData names the file and the line.
Result<PlyHeader> parse_ply_header(std::string_view bytes, std::string_view name_for_errors);

}  // namespace floatstage
