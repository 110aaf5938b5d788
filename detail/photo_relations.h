#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/result.h"
#include "detail/pair_relation.h"
#include "detail/watch.h"

namespace floatstage::detail {

/// A photograph of a folder.
struct Photo {
  std::string name;  ///< below the folder, with '/' between folders
  std::string hash;  ///< content_hash() of its file
  int width = 0, height = 0;
  int features = 0;
};

struct UnreadPhoto {
  std::string name, why;
};

/// All photographs of a folder and what each is to each other.
struct PhotoRelations {
  std::vector<Photo> photos;        ///< by name
  std::vector<UnreadPhoto> unread;  ///< files that could not be read, each with its sentence
  std::vector<PairRelation> pairs;  ///< photos.size()²: child's row, parent's column; the diagonal is empty
  std::size_t matched = 0;          ///< pairs that were not in the cache

  const PairRelation& pair(std::size_t child, std::size_t parent) const {
    return pairs[child * photos.size() + parent];
  }
};

struct RelationOptions {
  /// A folder for features and rows of pairs, known by the photographs' bytes: what is in it is not computed
  /// again, so that one more photograph costs its own row only. Made when it is not there; empty: none.
  std::filesystem::path cache;
  int threads = 0;  ///< 0: one per core
  Watch watch;
};

/// Relates all photographs in a folder and the folders in it (hidden ones are left out). The same whatever
/// the threads and the cache. Errors: NotFound; BadData when no photograph can be read; Cancelled (what was
/// found so far is in the cache); Io.
Result<PhotoRelations> relate_photos(const std::filesystem::path& folder, const RelationOptions& options);

}  // namespace floatstage::detail
