#include "core/ply_header.h"

#include <array>
#include <charconv>
#include <optional>
#include <utility>

#include "core/text.h"

namespace floatstage {
namespace {

using Words = std::vector<std::string_view>;

Words words_of(std::string_view line) {
  Words words;
  constexpr std::string_view kSpace = " \t\r";
  for (std::size_t at = line.find_first_not_of(kSpace); at != std::string_view::npos;
       at = line.find_first_not_of(kSpace, at)) {
    const std::size_t end = std::min(line.find_first_of(kSpace, at), line.size());
    words.push_back(line.substr(at, end - at));
    at = end;
  }
  return words;
}

std::optional<PlyType> type_named(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, PlyType>, 16> kNames = {{
      {"char", PlyType::Int8},
      {"int8", PlyType::Int8},
      {"uchar", PlyType::UInt8},
      {"uint8", PlyType::UInt8},
      {"short", PlyType::Int16},
      {"int16", PlyType::Int16},
      {"ushort", PlyType::UInt16},
      {"uint16", PlyType::UInt16},
      {"int", PlyType::Int32},
      {"int32", PlyType::Int32},
      {"uint", PlyType::UInt32},
      {"uint32", PlyType::UInt32},
      {"float", PlyType::Float32},
      {"float32", PlyType::Float32},
      {"double", PlyType::Float64},
      {"float64", PlyType::Float64},
  }};
  for (const auto& [known, type] : kNames)
    if (known == name) return type;
  return std::nullopt;
}

std::optional<PlyFormat> format_named(std::string_view name) {
  if (name == "ascii") return PlyFormat::Ascii;
  if (name == "binary_little_endian") return PlyFormat::LittleEndian;
  if (name == "binary_big_endian") return PlyFormat::BigEndian;
  return std::nullopt;
}

std::optional<PlyProperty> property_of(const Words& w) {
  PlyProperty p;
  if (w.size() == 5 && w[1] == "list") {
    const std::optional<PlyType> count = type_named(w[2]), item = type_named(w[3]);
    if (!count || !item || *count == PlyType::Float32 || *count == PlyType::Float64) return std::nullopt;
    return PlyProperty{std::string(w[4]), *item, *count, true};
  }
  if (w.size() != 3) return std::nullopt;
  const std::optional<PlyType> type = type_named(w[1]);
  if (!type) return std::nullopt;
  return PlyProperty{std::string(w[2]), *type, PlyType::UInt8, false};
}

// Takes one header line in; false when it makes no sense there.
bool read_line(const Words& w, PlyHeader& header, bool& has_format) {
  if (w.empty() || w[0] == "comment" || w[0] == "obj_info") return true;
  if (w[0] == "format") {
    const std::optional<PlyFormat> format =
        w.size() == 3 && w[2] == "1.0" && !has_format ? format_named(w[1]) : std::nullopt;
    if (format) header.format = *format;
    has_format = true;
    return format.has_value();
  }
  if (w[0] == "element" && w.size() == 3) {
    PlyElement e{std::string(w[1]), 0, {}};
    const auto [end, error] = std::from_chars(w[2].data(), w[2].data() + w[2].size(), e.count);
    if (error != std::errc() || end != w[2].data() + w[2].size()) return false;
    header.elements.push_back(std::move(e));
    return true;
  }
  if (w[0] == "property" && !header.elements.empty()) {
    std::optional<PlyProperty> property = property_of(w);
    if (property) header.elements.back().properties.push_back(std::move(*property));
    return property.has_value();
  }
  return false;
}

}  // namespace

std::size_t size_of(PlyType type) {
  constexpr std::size_t kSizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<int>(type)];
}

Result<PlyHeader> parse_ply_header(std::string_view bytes, std::string_view name) {
  PlyHeader header;
  bool has_format = false;
  for (int line = 1;; ++line) {
    const std::size_t end = bytes.find('\n', header.size_bytes);
    if (end == std::string_view::npos)
      return fail(ErrorCode::BadData,
                  text(name, ": the PLY header has no end; the file is cut off or no PLY"));
    const Words words = words_of(bytes.substr(header.size_bytes, end - header.size_bytes));
    header.size_bytes = end + 1;
    if (line == 1) {
      if (words != Words{"ply"})
        return fail(ErrorCode::BadData, text(name, ": not a PLY file (it does not begin with 'ply')"));
      continue;
    }
    if (words == Words{"end_header"}) break;
    if (!read_line(words, header, has_format))
      return fail(ErrorCode::BadData, text(name, ": line ", line, " of the PLY header makes no sense"));
  }
  if (!has_format) return fail(ErrorCode::BadData, text(name, ": the PLY header states no format"));
  return header;
}

}  // namespace floatstage
