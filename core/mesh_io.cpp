#include "core/mesh_io.h"

#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>

#include "core/file.h"
#include "core/ply_header.h"
#include "core/text.h"

namespace floatstage {
namespace {

static_assert(std::endian::native == std::endian::little, "save_ply writes memory as it is");

constexpr double kLongestList =
    std::numeric_limits<std::uint32_t>::max();  // what the widest PLY count can say

template <class T>
double decode(const char* at, bool swap) {
  char bytes[sizeof(T)];
  for (std::size_t i = 0; i < sizeof(T); ++i) bytes[i] = at[swap ? sizeof(T) - 1 - i : i];
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return static_cast<double>(value);
}

// The file's numbers one after the other, whatever its format. A double holds every PLY type exactly.
class Numbers {
 public:
  Numbers(std::string_view data, PlyFormat format) : data_(data), format_(format) {}

  std::size_t remaining() const { return data_.size(); }

  std::optional<double> next(PlyType type) {
    return format_ == PlyFormat::Ascii ? next_word() : next_binary(type);
  }

 private:
  std::optional<double> next_binary(PlyType type) {
    const std::size_t size = size_of(type);
    if (data_.size() < size) return std::nullopt;
    const char* at = data_.data();
    data_.remove_prefix(size);
    const bool swap = format_ == PlyFormat::BigEndian;
    switch (type) {
      case PlyType::Int8:
        return decode<std::int8_t>(at, swap);
      case PlyType::UInt8:
        return decode<std::uint8_t>(at, swap);
      case PlyType::Int16:
        return decode<std::int16_t>(at, swap);
      case PlyType::UInt16:
        return decode<std::uint16_t>(at, swap);
      case PlyType::Int32:
        return decode<std::int32_t>(at, swap);
      case PlyType::UInt32:
        return decode<std::uint32_t>(at, swap);
      case PlyType::Float32:
        return decode<float>(at, swap);
      case PlyType::Float64:
        return decode<double>(at, swap);
    }
    return std::nullopt;
  }

  std::optional<double> next_word() {
    constexpr std::string_view kSpace = " \t\r\n";
    data_.remove_prefix(std::min(data_.find_first_not_of(kSpace), data_.size()));
    if (data_.starts_with('+')) data_.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(data_.data(), data_.data() + data_.size(), value);
    const std::size_t used = static_cast<std::size_t>(end - data_.data());
    if (error != std::errc() || (used < data_.size() && kSpace.find(*end) == std::string_view::npos))
      return std::nullopt;
    data_.remove_prefix(used);
    return value;
  }

  std::string_view data_;
  PlyFormat format_;
};

class Reader {
 public:
  Reader(const PlyHeader& header, std::string_view data, std::string_view name)
      : header_(header), numbers_(data, header.format), name_(name) {}

  Result<Mesh> read() {
    for (const PlyElement& element : header_.elements) {
      if (element.properties.empty()) continue;  // nothing to read, however many
      Result<void> done = element.name == "vertex" ? read_vertices(element)
                          : element.name == "face" ? read_faces(element)
                                                   : skip(element);
      if (!done) return forward(done);
    }
    if (!has_vertices_) return bad("the PLY has no vertices");
    for (std::uint32_t index : mesh_.triangles)
      if (index >= mesh_.positions.size())
        return bad(text("a face names vertex ", index, " of ", mesh_.positions.size()));
    return std::move(mesh_);
  }

 private:
  Unexpected bad(const std::string& what) const { return fail(ErrorCode::BadData, text(name_, ": ", what)); }
  Unexpected truncated(const PlyElement& element, std::uint64_t index) const {
    return bad(
        text("the data of ", element.name, " ", index, " of ", element.count, " is cut off or not numbers"));
  }

  // Reads one property and hands every number of it to `use`.
  template <class Use>
  bool read_property(const PlyProperty& p, Use use) {
    if (!p.is_list) {
      const std::optional<double> value = numbers_.next(p.type);
      return value && use(*value);
    }
    const std::optional<double> count = numbers_.next(p.count_type);
    if (!count || !(*count >= 0) || *count > kLongestList || *count != std::floor(*count)) return false;
    for (std::uint64_t left = static_cast<std::uint64_t>(*count); left > 0; --left) {
      const std::optional<double> value = numbers_.next(p.type);
      if (!value || !use(*value)) return false;
    }
    return true;
  }

  Result<void> skip(const PlyElement& element) {
    for (std::uint64_t i = 0; i < element.count; ++i)
      for (const PlyProperty& p : element.properties)
        if (!read_property(p, [](double) { return true; })) return truncated(element, i);
    return {};
  }

  Result<void> read_vertices(const PlyElement& element) {
    if (has_vertices_) return bad("the PLY has two lists of vertices");
    std::vector<int> axis_of(element.properties.size(), -1);
    int axes = 0;
    for (std::size_t k = 0; k < element.properties.size(); ++k) {
      const PlyProperty& p = element.properties[k];
      if (p.is_list || p.name.size() != 1 || p.name[0] < 'x' || p.name[0] > 'z') continue;
      axis_of[k] = p.name[0] - 'x';
      axes |= 1 << axis_of[k];
    }
    if (axes != 7) return bad("the vertices have no x, y and z");
    if (element.count > std::numeric_limits<std::uint32_t>::max())
      return bad("more than 4294967295 vertices");
    mesh_.positions.reserve(
        std::min<std::uint64_t>(element.count, numbers_.remaining() / 3));  // a lying count costs no memory
    for (std::uint64_t i = 0; i < element.count; ++i) {
      Eigen::Vector3f position = Eigen::Vector3f::Zero();
      for (std::size_t k = 0; k < element.properties.size(); ++k)
        if (!read_property(element.properties[k], [&](double v) {
              if (axis_of[k] >= 0) position[axis_of[k]] = static_cast<float>(v);
              return true;
            }))
          return truncated(element, i);
      if (!position.allFinite()) return bad(text("the position of vertex ", i, " is not finite"));
      mesh_.positions.push_back(position);
    }
    has_vertices_ = true;
    return {};
  }

  Result<void> read_faces(const PlyElement& element) {
    std::vector<std::uint32_t> polygon;
    bool has_indices = false;
    for (const PlyProperty& p : element.properties) has_indices |= is_indices(p);
    if (!has_indices) return bad("the faces have no list of vertex indices");
    for (std::uint64_t i = 0; i < element.count; ++i) {
      for (const PlyProperty& p : element.properties) {
        polygon.clear();
        bool whole = true;
        const bool read = read_property(p, [&](double v) {
          if (!is_indices(p)) return true;
          whole = v >= 0 && v <= std::numeric_limits<std::uint32_t>::max() && v == std::floor(v);
          if (whole) polygon.push_back(static_cast<std::uint32_t>(v));
          return whole;
        });
        if (!whole) return bad(text("face ", i, " names a vertex that cannot exist"));
        if (!read) return truncated(element, i);
        if (!is_indices(p)) continue;
        if (polygon.size() < 3) return bad(text("face ", i, " has ", polygon.size(), " corners"));
        for (std::size_t k = 2; k < polygon.size(); ++k)
          mesh_.triangles.insert(mesh_.triangles.end(), {polygon[0], polygon[k - 1], polygon[k]});
      }
    }
    return {};
  }

  static bool is_indices(const PlyProperty& p) {
    return p.is_list && (p.name == "vertex_indices" || p.name == "vertex_index");
  }

  const PlyHeader& header_;
  Numbers numbers_;
  std::string_view name_;
  Mesh mesh_;
  bool has_vertices_ = false;
};

}  // namespace

Result<void> save_ply(const Mesh& mesh, const std::filesystem::path& file) {
  static_assert(sizeof(Eigen::Vector3f) == 3 * sizeof(float), "positions are written as they are");
  FLOATSTAGE_CHECK(mesh.triangles.size() % 3 == 0, "a mesh with a third of a triangle");
  std::string bytes = text("ply\nformat binary_little_endian 1.0\nelement vertex ", mesh.positions.size(),
                           "\nproperty float x\nproperty float y\nproperty float z\nelement face ",
                           mesh.triangle_count(), "\nproperty list uchar int vertex_indices\nend_header\n");
  constexpr std::size_t kTriangle = 3 * sizeof(std::uint32_t);
  bytes.reserve(bytes.size() + mesh.positions.size() * sizeof(Eigen::Vector3f) +
                mesh.triangle_count() * (1 + kTriangle));
  bytes.append(reinterpret_cast<const char*>(mesh.positions.data()),
               mesh.positions.size() * sizeof(Eigen::Vector3f));
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    bytes.push_back(3);
    bytes.append(reinterpret_cast<const char*>(&mesh.triangles[t]), kTriangle);
  }
  return write_file(file, bytes);
}

Result<Mesh> parse_ply(std::span<const std::byte> bytes, std::string_view name) {
  const std::string_view view(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const Result<PlyHeader> header = parse_ply_header(view, name);
  if (!header) return forward(header);
  return Reader(*header, view.substr(header->size_bytes), name).read();
}

Result<Mesh> load_ply(const std::filesystem::path& file) {
  const Result<std::string> bytes = read_file(file);
  if (!bytes) return forward(bytes);
  return parse_ply(std::as_bytes(std::span(*bytes)), file.string());
}

}  // namespace floatstage
