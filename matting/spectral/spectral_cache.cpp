#include "matting/spectral/spectral_cache.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "core/text.h"

namespace floatstage::matting {
namespace {

static_assert(std::endian::native == std::endian::little, "the files are little endian");

constexpr char kMagic[8] = {'f', 's', 's', 'p', 'e', 'c', 't', '\n'};
constexpr std::uint32_t kVersion = 1, kEigenpairs = 1, kComponents = 2;
constexpr std::uint32_t kLargestSide = 8192, kMostColumns = 512;
constexpr float kSteps = 32767;

struct Header {
  char magic[8];
  std::uint32_t version, kind, width, height, columns, padding;
  std::uint64_t key;
  double residual;
};
static_assert(sizeof(Header) == 48);

float scale_of(const Eigen::MatrixXf& columns, Eigen::Index c) {
  return columns.col(c).cwiseAbs().maxCoeff() / kSteps;
}

std::int16_t step_of(float value, float scale) {
  return scale > 0 ? static_cast<std::int16_t>(std::lround(value / scale)) : std::int16_t{0};
}

template <class T>
void append(std::string& out, const T* values, std::size_t count) {
  out.append(reinterpret_cast<const char*>(values), count * sizeof(T));
}

std::string to_bytes(std::uint32_t kind, int width, int height, std::uint64_t key, double residual,
                     const Eigen::VectorXd& values, const Eigen::MatrixXf& columns) {
  Header header{{},
                kVersion,
                kind,
                static_cast<std::uint32_t>(width),
                static_cast<std::uint32_t>(height),
                static_cast<std::uint32_t>(columns.cols()),
                0,
                key,
                residual};
  std::copy_n(kMagic, sizeof kMagic, header.magic);
  std::string out;
  out.reserve(sizeof header + static_cast<std::size_t>(columns.size() * 2 + columns.cols() * 12 + 8));
  append(out, &header, 1);
  append(out, values.data(), static_cast<std::size_t>(values.size()));
  std::vector<std::int16_t> steps(static_cast<std::size_t>(columns.rows()));
  for (Eigen::Index c = 0; c < columns.cols(); ++c) {
    const float scale = scale_of(columns, c);
    append(out, &scale, 1);
  }
  for (Eigen::Index c = 0; c < columns.cols(); ++c) {
    const float scale = scale_of(columns, c);
    for (std::size_t i = 0; i < steps.size(); ++i)
      steps[i] = step_of(columns(static_cast<Eigen::Index>(i), c), scale);
    append(out, steps.data(), steps.size());
  }
  const std::uint64_t hash = hash_of(out);
  append(out, &hash, 1);
  return out;
}

struct Parsed {
  Header header;
  Eigen::VectorXd values;
  Eigen::MatrixXf columns;
};

Result<Parsed> parse(std::string_view bytes, std::uint32_t kind, std::string_view name) {
  const auto bad = [&](const char* what) {
    return fail(ErrorCode::BadData, text(name, " ", what, "; it can be deleted and is made again"));
  };
  Parsed p{};
  if (bytes.size() < sizeof(Header) + sizeof(std::uint64_t)) return bad("is cut off");
  std::memcpy(&p.header, bytes.data(), sizeof(Header));
  const Header& h = p.header;
  if (!std::equal(kMagic, kMagic + sizeof kMagic, h.magic)) return bad("is no file of matting components");
  if (h.version != kVersion) return bad("has another version");
  if (h.kind != kind) return bad("is of another kind");
  if (h.width == 0 || h.height == 0 || h.columns == 0 || h.width > kLargestSide || h.height > kLargestSide ||
      h.columns > kMostColumns)
    return bad("has an impossible size");
  const std::size_t pixels = static_cast<std::size_t>(h.width) * h.height;
  const std::size_t body =
      sizeof(Header) + h.columns * (sizeof(double) + sizeof(float) + pixels * sizeof(std::int16_t));
  if (bytes.size() != body + sizeof(std::uint64_t)) return bad("is cut off");
  std::uint64_t hash;
  std::memcpy(&hash, bytes.data() + body, sizeof hash);
  if (hash != hash_of(bytes.substr(0, body))) return bad("is damaged");
  const char* at = bytes.data() + sizeof(Header);
  p.values.resize(h.columns);
  std::memcpy(p.values.data(), at, h.columns * sizeof(double));
  at += h.columns * sizeof(double);
  std::vector<float> scales(h.columns);
  std::memcpy(scales.data(), at, h.columns * sizeof(float));
  at += h.columns * sizeof(float);
  if (!p.values.allFinite() ||
      !std::all_of(scales.begin(), scales.end(), [](float s) { return std::isfinite(s); }))
    return bad("has numbers that are none");
  p.columns.resize(static_cast<Eigen::Index>(pixels), h.columns);
  std::vector<std::int16_t> steps(pixels);
  for (Eigen::Index c = 0; c < p.columns.cols(); ++c, at += pixels * sizeof(std::int16_t)) {
    std::memcpy(steps.data(), at, pixels * sizeof(std::int16_t));
    for (std::size_t i = 0; i < pixels; ++i)
      p.columns(static_cast<Eigen::Index>(i), c) =
          static_cast<float>(steps[i]) * scales[static_cast<std::size_t>(c)];
  }
  return p;
}

}  // namespace

std::uint64_t hash_of(std::string_view bytes, std::uint64_t hash) {
  // Eight bytes a step: the files have megabytes.
  std::size_t i = 0;
  for (; i + 8 <= bytes.size(); i += 8) {
    std::uint64_t word;
    std::memcpy(&word, bytes.data() + i, 8);
    hash = (hash ^ word) * 1099511628211u;
    hash ^= hash >> 32;
  }
  for (; i < bytes.size(); ++i) hash = (hash ^ static_cast<unsigned char>(bytes[i])) * 1099511628211u;
  return hash;
}

void quantize(Eigen::MatrixXf& columns) {
  for (Eigen::Index c = 0; c < columns.cols(); ++c) {
    const float scale = scale_of(columns, c);
    for (Eigen::Index i = 0; i < columns.rows(); ++i)
      columns(i, c) = static_cast<float>(step_of(columns(i, c), scale)) * scale;
  }
}

std::string to_bytes(const EigenPairs& pairs, std::uint64_t key) {
  return to_bytes(kEigenpairs, pairs.width, pairs.height, key, pairs.residual, pairs.values, pairs.vectors);
}

std::string to_bytes(const MattingComponents& components, std::uint64_t key) {
  return to_bytes(kComponents, components.width, components.height, key, 0,
                  Eigen::VectorXd::Zero(components.alpha.cols()), components.alpha);
}

Result<EigenPairs> parse_eigenpairs(std::string_view bytes, std::uint64_t& key, std::string_view name) {
  auto p = parse(bytes, kEigenpairs, name);
  if (!p) return forward(p);
  key = p->header.key;
  return EigenPairs{static_cast<int>(p->header.width), static_cast<int>(p->header.height),
                    std::move(p->values), std::move(p->columns), p->header.residual};
}

Result<MattingComponents> parse_components(std::string_view bytes, std::uint64_t& key,
                                           std::string_view name) {
  auto p = parse(bytes, kComponents, name);
  if (!p) return forward(p);
  key = p->header.key;
  return MattingComponents{static_cast<int>(p->header.width), static_cast<int>(p->header.height),
                           std::move(p->columns)};
}

}  // namespace floatstage::matting
