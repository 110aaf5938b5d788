#include "detail/relation_cache.h"

#include <cmath>
#include <cstring>
#include <type_traits>

#include "core/content_hash.h"
#include "core/file.h"
#include "core/json_fields.h"
#include "core/log.h"
#include "core/text.h"

namespace floatstage::detail {
namespace {

// Grows whenever other features or relations would be found in the same photographs.
constexpr int kVersion = 1;
constexpr std::string_view kMagic = "floatstage features 1\n";
constexpr std::size_t kHash = 32, kLongest = 256 << 20;
constexpr int kMostFeatures = 1 << 20, kMostSide = 1 << 20;

static_assert(std::is_trivially_copyable_v<Eigen::Vector2d> || sizeof(Eigen::Vector2d) == 16);

template <class T>
void append(std::string& out, const T* values, std::size_t count) {
  out.append(reinterpret_cast<const char*>(values), count * sizeof(T));
}

/// Takes values from the front of bytes, and remembers when there were too few.
struct Reader {
  std::string_view rest;
  bool whole = true;
  template <class T>
  void read(T* values, std::size_t count) {
    if (rest.size() < count * sizeof(T)) {
      whole = false;
      return;
    }
    if (count > 0) std::memcpy(values, rest.data(), count * sizeof(T));
    rest.remove_prefix(count * sizeof(T));
  }
};

PairRelation relation_of(JsonFields& row) {
  PairRelation r;
  r.matches = row.integer("matches");
  r.inliers = row.integer("inliers");
  const std::vector<double> h = row.numbers("homography", 9);
  for (int i = 0; i < 9; ++i) r.parent_from_child(i / 3, i % 3) = h[static_cast<std::size_t>(i)];
  r.zoom = row.number("zoom");
  r.inside = row.number("inside");
  r.rms = row.number("rms");
  r.why = row.string("why");
  return r;
}

}  // namespace

std::string features_to_bytes(const PhotoFeatures& f) {
  std::string payload;
  const std::int32_t sizes[] = {f.width, f.height, f.count()};
  append(payload, sizes, 3);
  append(payload, &f.scale, 1);
  for (const Eigen::Vector2d& p : f.points) append(payload, p.data(), 2);
  append(payload, f.sizes.data(), f.sizes.size());
  append(payload, f.descriptors.data(), f.descriptors.size());
  return text(kMagic, content_hash(payload), payload);
}

std::optional<PhotoFeatures> features_from_bytes(std::string_view bytes) {
  if (!bytes.starts_with(kMagic) || bytes.size() < kMagic.size() + kHash) return std::nullopt;
  const std::string_view hash = bytes.substr(kMagic.size(), kHash),
                         payload = bytes.substr(kMagic.size() + kHash);
  if (content_hash(payload) != hash) return std::nullopt;
  Reader in{payload};
  PhotoFeatures f;
  std::int32_t sizes[3] = {};
  in.read(sizes, 3);
  in.read(&f.scale, 1);
  const std::int32_t count = sizes[2];
  if (!in.whole || count < 0 || count > kMostFeatures || sizes[0] < 1 || sizes[1] < 1 ||
      sizes[0] > kMostSide || sizes[1] > kMostSide || !(f.scale >= 1 && f.scale <= kMostSide))
    return std::nullopt;
  constexpr std::size_t kEach = sizeof(double) * 2 + sizeof(float) + PhotoFeatures::kLength;
  if (in.rest.size() != static_cast<std::size_t>(count) * kEach) return std::nullopt;
  f.width = sizes[0];
  f.height = sizes[1];
  f.points.resize(static_cast<std::size_t>(count));
  f.sizes.resize(f.points.size());
  f.descriptors.resize(f.points.size() * PhotoFeatures::kLength);
  for (Eigen::Vector2d& p : f.points) {
    in.read(p.data(), 2);
    if (!p.allFinite()) return std::nullopt;
  }
  in.read(f.sizes.data(), f.sizes.size());
  in.read(f.descriptors.data(), f.descriptors.size());
  return in.whole ? std::optional(std::move(f)) : std::nullopt;
}

std::string pairs_to_json(const PairRows& rows) {
  nlohmann::json pairs = nlohmann::json::array();
  for (const auto& [hashes, r] : rows) {
    nlohmann::json h = nlohmann::json::array();
    for (int i = 0; i < 9; ++i) h.push_back(r.parent_from_child(i / 3, i % 3));
    pairs.push_back({{"child", hashes.first},
                     {"parent", hashes.second},
                     {"matches", r.matches},
                     {"inliers", r.inliers},
                     {"homography", h},
                     {"zoom", r.zoom},
                     {"inside", r.inside},
                     {"rms", r.rms},
                     {"why", r.why}});
  }
  return nlohmann::json{{"format", "floatstage-pairs"}, {"version", kVersion}, {"pairs", pairs}}.dump();
}

Result<PairRows> pairs_from_json(std::string_view json, std::string_view name) {
  const Result<nlohmann::json> parsed = parse_json(json, name, kLongest);
  if (!parsed) return forward(parsed);
  JsonProblem problem;
  JsonFields document(*parsed, std::string(name), problem);
  PairRows rows;
  if (document.string("format") != "floatstage-pairs" || document.integer("version") != kVersion)
    problem.note(document.where(), "pairs of another program or version");
  if (const nlohmann::json* pairs = document.list("pairs"); pairs != nullptr && !problem.first)
    for (const nlohmann::json& pair : *pairs) {
      JsonFields row(pair, text(name, ": a pair"), problem);
      std::pair<std::string, std::string> hashes{row.string("child"), row.string("parent")};
      rows[std::move(hashes)] = relation_of(row);
      row.refuse_others();
      if (problem.first) break;
    }
  document.refuse_others();
  if (problem.first) return fail(ErrorCode::BadData, *problem.first);
  return rows;
}

RelationCache::RelationCache(std::filesystem::path folder) : folder_(std::move(folder)) {
  if (folder_.empty()) return;
  const std::filesystem::path file = folder_ / "pairs.json";
  const Result<std::string> json = read_file(file);
  if (!json) return;
  if (Result<PairRows> rows = pairs_from_json(*json, file.string()))
    rows_ = std::move(*rows);
  else
    log::warning(text(rows.error().message, "; pairs are related again"));
}

std::optional<PhotoFeatures> RelationCache::features(const std::string& hash) const {
  if (folder_.empty()) return std::nullopt;
  const Result<std::string> bytes = read_file(folder_ / (hash + ".features"));
  return bytes ? features_from_bytes(*bytes) : std::nullopt;
}

void RelationCache::keep(const std::string& hash, const PhotoFeatures& features) const {
  if (folder_.empty()) return;
  if (const Result<void> ok = write_file(folder_ / (hash + ".features"), features_to_bytes(features)); !ok)
    log::warning(ok.error().message);
}

Result<void> RelationCache::keep(PairRows rows) {
  rows_ = std::move(rows);
  return folder_.empty() ? Result<void>() : write_file(folder_ / "pairs.json", pairs_to_json(rows_));
}

}  // namespace floatstage::detail
