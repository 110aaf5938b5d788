#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "core/result.h"
#include "detail/features.h"
#include "detail/pair_relation.h"

namespace floatstage::detail {

/// Features as bytes with a hash of their own, and back: absent where anything was changed or cut off.
std::string features_to_bytes(const PhotoFeatures& features);
std::optional<PhotoFeatures> features_from_bytes(std::string_view bytes);

/// Pairs by the hashes of child and parent.
using PairRows = std::map<std::pair<std::string, std::string>, PairRelation>;

/// The rows as JSON, and back. BadData, naming it, for anything that is no such document.
std::string pairs_to_json(const PairRows& rows);
Result<PairRows> pairs_from_json(std::string_view json, std::string_view name_for_errors);

/// A folder that keeps both. What is damaged in it, or made by another version, is as if it were not there.
/// Not for two threads at once.
class RelationCache {
 public:
  explicit RelationCache(std::filesystem::path folder);  ///< empty: keeps nothing
  std::optional<PhotoFeatures> features(const std::string& hash) const;
  void keep(const std::string& hash, const PhotoFeatures& features) const;
  const PairRows& rows() const { return rows_; }
  /// Io when the folder cannot be written to.
  Result<void> keep(PairRows rows);

 private:
  std::filesystem::path folder_;
  PairRows rows_;
};

}  // namespace floatstage::detail
