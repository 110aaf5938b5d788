#include "pipeline/import/gltf_file.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <stdexcept>

#include "core/file.h"
#include "core/json_fields.h"
#include "core/text.h"

namespace floatstage::pipeline {
namespace {

using nlohmann::json;

[[noreturn]] void refuse(const std::string& what) { throw std::invalid_argument(what); }

std::uint32_t number_at(std::string_view bytes, std::size_t at) {
  std::uint32_t value = 0;
  if (at + sizeof value > bytes.size()) refuse("the file is cut short");
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

std::string from_base64(std::string_view coded) {
  static constexpr std::string_view kLetters =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  std::uint32_t bits = 0;
  int have = 0;
  for (const char c : coded) {
    if (c == '=') break;
    const std::size_t value = kLetters.find(c);
    if (value == std::string_view::npos) refuse("a buffer's base64 holds other characters");
    bits = bits << 6 | static_cast<std::uint32_t>(value);
    have += 6;
    if (have < 8) continue;
    have -= 8;
    out.push_back(static_cast<char>(bits >> have & 255));
  }
  return out;
}

// Bytes of a component, and what a whole number of it stands for 1.
struct Component {
  std::size_t bytes;
  double one;  // 0: a float
};

Component component_of(int type) {
  switch (type) {
    case 5120:
      return {1, 127};
    case 5121:
      return {1, 255};
    case 5122:
      return {2, 32767};
    case 5123:
      return {2, 65535};
    case 5126:
      return {4, 0};
    default:
      refuse(text("numbers of kind ", type, " move no camera"));
  }
}

double component_at(const char* at, int type) {
  const auto read = [&]<class T>(T value) {
    std::memcpy(&value, at, sizeof value);
    return static_cast<double>(value);
  };
  switch (type) {
    case 5120:
      return read(std::int8_t{});
    case 5121:
      return read(std::uint8_t{});
    case 5122:
      return read(std::int16_t{});
    case 5123:
      return read(std::uint16_t{});
    default:
      return read(float{});
  }
}

std::size_t width_of(const std::string& type) {
  if (type == "SCALAR") return 1;
  if (type == "VEC3") return 3;
  if (type == "VEC4") return 4;
  refuse(text("elements of type ", type, " move no camera"));
}

}  // namespace

GltfFile::GltfFile(std::string_view bytes, std::string_view name, std::filesystem::path folder)
    : folder_(std::move(folder)) {
  std::string_view words = bytes;
  if (bytes.starts_with("glTF")) {
    if (const std::uint32_t version = number_at(bytes, 4); version != 2)
      refuse(text("it is of glTF's version ", version, "; write it as 2.0"));
    const std::size_t length = number_at(bytes, 12);
    if (number_at(bytes, 8) > bytes.size() || length > bytes.size() - 20) refuse("the file is cut short");
    if (bytes.substr(16, 4) != "JSON") refuse("its first part is no JSON");
    words = bytes.substr(20, length);
    if (const std::size_t next = 20 + length; next < bytes.size()) {
      const std::size_t rest = number_at(bytes, next);
      if (next + 8 > bytes.size() || rest > bytes.size() - next - 8) refuse("the file is cut short");
      chunk_ = bytes.substr(next + 8, rest);
    }
  }
  Result<json> parsed = parse_json(words, name);
  if (!parsed) refuse(parsed.error().message);
  document_ = std::move(*parsed);
  if (!document_.is_object() || !document_.contains("asset")) refuse("it is no glTF: it has no \"asset\"");
  if (const std::string version = document_.at("asset").at("version"); !version.starts_with("2."))
    refuse(text("it is of glTF's version ", version, "; write it as 2.0"));
  buffers_.resize(list("buffers").size());
}

const json& GltfFile::list(const char* key) const {
  static const json kNone = json::array();
  const auto found = document_.find(key);
  return found != document_.end() && found->is_array() ? *found : kNone;
}

std::string_view GltfFile::buffer(std::size_t index) const {
  const json& about = list("buffers").at(index);
  if (!about.contains("uri")) {
    if (index != 0 || chunk_.empty()) refuse(text("buffer ", index, " is nowhere"));
    return chunk_;
  }
  std::string& bytes = buffers_[index];
  if (!bytes.empty()) return bytes;
  const std::string uri = about.at("uri");
  if (uri.starts_with("data:")) {
    const std::size_t comma = uri.find(";base64,");
    if (comma == std::string::npos) refuse(text("buffer ", index, " is not in base64"));
    bytes = from_base64(std::string_view(uri).substr(comma + 8));
    return bytes;
  }
  // A file beside this one and no other: its name is a stranger's.
  if (uri.find_first_of("/\\:%") != std::string::npos || uri.starts_with("."))
    refuse(text("buffer ", index, " lies at ", uri, ", which is not a file beside it; write a .glb"));
  Result<std::string> read = read_file(folder_ / uri);
  if (!read) refuse(read.error().message);
  bytes = std::move(*read);
  return bytes;
}

GltfNumbers GltfFile::numbers(std::size_t index) const {
  const json& accessor = list("accessors").at(index);
  if (accessor.contains("sparse") || !accessor.contains("bufferView"))
    refuse("sparse numbers are not read; write the animation without them");
  const int type = accessor.at("componentType");
  const Component component = component_of(type);
  GltfNumbers numbers;
  numbers.width = width_of(accessor.at("type"));
  const std::size_t count = accessor.at("count").get<std::uint32_t>(),
                    element = component.bytes * numbers.width;
  const json& view = list("bufferViews").at(accessor.at("bufferView").get<std::uint32_t>());
  const std::string_view bytes = buffer(view.at("buffer").get<std::uint32_t>());
  const std::size_t begin = std::size_t{view.value("byteOffset", std::uint32_t{0})} +
                            accessor.value("byteOffset", std::uint32_t{0}),
                    stride = view.value("byteStride", static_cast<std::uint32_t>(element));
  if (count == 0 || stride < element || begin + (count - 1) * stride + element > bytes.size())
    refuse(text("numbers ", index, " lie beyond the end of their buffer: the file is cut short"));
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t k = 0; k < numbers.width; ++k) {
      const double value = component_at(bytes.data() + begin + i * stride + k * component.bytes, type);
      if (!std::isfinite(value)) refuse(text("numbers ", index, " are not all finite"));
      numbers.values.push_back(component.one > 0 ? std::max(value / component.one, -1.0) : value);
    }
  return numbers;
}

}  // namespace floatstage::pipeline
