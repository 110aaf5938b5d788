#include "render/flow/flo_file.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "core/file.h"
#include "core/text.h"

namespace floatstage::render {
namespace {

constexpr float kTag = 202021.25F;  // "PIEH" as bytes
constexpr float kUnknownAbove = 1e9F;
constexpr std::int32_t kLargestSide = 32768;
constexpr std::size_t kHeader = 12, kPixel = 8;  // bytes

static_assert(std::endian::native == std::endian::little, "a .flo file is read as it lies in memory");

template <class T>
T read_at(std::span<const std::byte> bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

template <class T>
void append(std::string& bytes, T value) {
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  bytes.append(raw, sizeof value);
}

}  // namespace

bool is_known(float u, float v) {
  return std::abs(u) <= kUnknownAbove && std::abs(v) <= kUnknownAbove;  // false for NaN
}

Result<FlowField> decode_flo(std::span<const std::byte> bytes, std::string_view name) {
  auto bad = [&](const auto&... parts) { return fail(ErrorCode::BadData, text(name, ": ", parts...)); };
  if (bytes.size() < kHeader || read_at<float>(bytes, 0) != kTag)
    return bad("this is not a .flo file (it does not begin with 202021.25 as a float, \"PIEH\")");
  const auto width = read_at<std::int32_t>(bytes, 4), height = read_at<std::int32_t>(bytes, 8);
  if (width < 1 || height < 1 || width > kLargestSide || height > kLargestSide)
    return bad("a flow field of ", width, "x", height, "; 1 to ", kLargestSide, " px a side are possible");
  const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  if (bytes.size() != kHeader + kPixel * pixels)
    return bad(bytes.size(), " bytes are not the ", kHeader + kPixel * pixels, " of a flow field of ", width,
               "x", height, "; it was cut off or is another kind of file");
  FlowField field{width, height, std::vector<float>(2 * pixels)};
  std::memcpy(field.uv.data(), bytes.data() + kHeader, kPixel * pixels);
  return field;
}

Result<FlowField> load_flo(const std::filesystem::path& file) {
  const Result<std::string> bytes = read_file(file);
  if (!bytes) return forward(bytes);
  return decode_flo(std::as_bytes(std::span(bytes->data(), bytes->size())), file.string());
}

std::string encode_flo(const FlowField& field) {
  std::string bytes;
  bytes.reserve(kHeader + field.uv.size() * sizeof(float));
  append(bytes, kTag);
  append(bytes, static_cast<std::int32_t>(field.width));
  append(bytes, static_cast<std::int32_t>(field.height));
  bytes.append(reinterpret_cast<const char*>(field.uv.data()), field.uv.size() * sizeof(float));
  return bytes;
}

Result<void> save_flo(const FlowField& field, const std::filesystem::path& file) {
  if (field.width < 1 || field.height < 1)
    return fail(ErrorCode::InvalidArgument, text(file.string(), ": a flow field without pixels"));
  return write_file(file, encode_flo(field));
}

}  // namespace floatstage::render
