#include "pipeline/field_file.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>

#include "core/content_hash.h"
#include "core/file.h"
#include "core/text.h"

namespace floatstage::pipeline {
namespace {

constexpr std::string_view kMagic = "FSFIELD1";
constexpr std::size_t kHash = 32;  // characters of a content_hash()
constexpr std::uint32_t kLongestName = 255, kMostNeighbors = 64;

static_assert(std::endian::native == std::endian::little, "numbers lie in files as in memory");

class Writer {
 public:
  template <class T>
  void value(T v) {
    bytes_.append(reinterpret_cast<const char*>(&v), sizeof v);
  }
  void word(std::string_view s) {
    value(static_cast<std::uint32_t>(s.size()));
    bytes_.append(s);
  }
  void raw(const void* from, std::size_t size) { bytes_.append(static_cast<const char*>(from), size); }
  std::string bytes_;
};

/// Reads until something is missing; then all that follows is empty, and `whole` says so.
class Reader {
 public:
  explicit Reader(std::string_view bytes) : rest_(bytes) {}
  template <class T>
  T value() {
    T v{};
    if (const std::string_view from = raw(sizeof v); !from.empty()) std::memcpy(&v, from.data(), sizeof v);
    return v;
  }
  std::string word() {
    const auto size = value<std::uint32_t>();
    if (size > kLongestName) whole_ = false;
    return std::string(raw(whole_ ? size : 0));
  }
  std::string_view raw(std::size_t size) {
    whole_ = whole_ && size <= rest_.size();
    if (!whole_) return {};
    const std::string_view taken = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return taken;
  }
  bool whole() const { return whole_; }
  bool at_end() const { return rest_.empty(); }

 private:
  std::string_view rest_;
  bool whole_ = true;
};

bool sound(const FieldFile& f) {
  constexpr int kSide = render::CameraField::kLargestSide;
  const bool nothing = f.width == 0 && f.height == 0;
  const bool grid = f.width >= 2 && f.height >= 2 && f.width <= kSide && f.height <= kSide &&
                    f.place[0] > 0 && f.place[1] > 0;
  return (nothing || grid) &&
         std::all_of(f.place.begin(), f.place.end(), [](float v) { return std::isfinite(v); });
}

}  // namespace

std::string encode_fields(const FieldFile& f) {
  Writer w;
  w.raw(kMagic.data(), kMagic.size());
  w.word(f.flow.backend);
  w.word(f.flow.preset);
  for (const int n : {f.flow.finest_scale, f.flow.iterations, f.flow.refinement, f.flow.shrink}) w.value(n);
  w.word(f.mesh);
  w.word(f.camera);
  for (const float v : f.place) w.value(v);
  w.value(f.width);
  w.value(f.height);
  w.value(static_cast<std::uint32_t>(f.neighbors.size()));
  for (const FieldFile::Neighbor& n : f.neighbors) {
    w.word(n.serial);
    w.word(n.made_from);
    w.raw(n.uv.data(), n.uv.size() * sizeof(std::int16_t));
  }
  w.bytes_ += content_hash(w.bytes_);
  return std::move(w.bytes_);
}

Result<FieldFile> decode_fields(std::string_view bytes, std::string_view name) {
  auto bad = [&](const auto&... parts) {
    return fail(ErrorCode::BadData, text(name, ": ", parts...,
                                         "; remove it, or make it again with `floatstage process --fields`"));
  };
  if (!bytes.starts_with(kMagic)) return bad("these are no fields (the file does not begin with FSFIELD1)");
  if (bytes.size() < kMagic.size() + kHash ||
      content_hash(bytes.substr(0, bytes.size() - kHash)) != bytes.substr(bytes.size() - kHash))
    return bad("the file was cut off or damaged");
  Reader r(bytes.substr(kMagic.size(), bytes.size() - kMagic.size() - kHash));
  FieldFile f;
  f.flow.backend = r.word();
  f.flow.preset = r.word();
  for (int* n : {&f.flow.finest_scale, &f.flow.iterations, &f.flow.refinement, &f.flow.shrink})
    *n = r.value<int>();
  f.mesh = r.word();
  f.camera = r.word();
  for (float& v : f.place) v = r.value<float>();
  f.width = r.value<int>();
  f.height = r.value<int>();
  const auto count = r.value<std::uint32_t>();
  if (!r.whole() || !sound(f) || count > kMostNeighbors) return bad("its head makes no sense");
  const std::size_t numbers = 2 * static_cast<std::size_t>(f.width) * static_cast<std::size_t>(f.height);
  for (std::uint32_t i = 0; i < count && r.whole(); ++i) {
    FieldFile::Neighbor& n = f.neighbors.emplace_back();
    n.serial = r.word();
    n.made_from = r.word();
    const std::string_view raw = r.raw(numbers * sizeof(std::int16_t));
    n.uv.resize(raw.size() / sizeof(std::int16_t));
    if (!raw.empty()) std::memcpy(n.uv.data(), raw.data(), raw.size());
  }
  if (!r.whole() || !r.at_end()) return bad("it does not end where its head says");
  return f;
}

Result<FieldFile> load_field_file(const std::filesystem::path& file) {
  const Result<std::string> bytes = read_file(file);
  if (!bytes) return forward(bytes);
  return decode_fields(*bytes, file.string());
}

Result<void> save_field_file(const FieldFile& fields, const std::filesystem::path& file) {
  if (Result<void> ok = make_folder(file.parent_path()); !ok) return ok;
  return write_file(file, encode_fields(fields));
}

}  // namespace floatstage::pipeline
