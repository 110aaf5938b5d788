#include "detail/photo_relations.h"

#include <algorithm>
#include <atomic>
#include <optional>

#include "core/content_hash.h"
#include "core/file.h"
#include "core/parallel.h"
#include "core/text.h"
#include "detail/photo_file.h"
#include "detail/relation_cache.h"

namespace floatstage::detail {
namespace {

namespace fs = std::filesystem;

class Part {
 public:
  Part(const Watch& watch, const char* what, std::size_t total) : watch_(watch) {
    if (watch_.begin) watch_.begin(what, total);
  }
  ~Part() {
    if (watch_.end) watch_.end();
  }
  Part(const Part&) = delete;
  Part& operator=(const Part&) = delete;
  void advance() const {
    if (watch_.advance) watch_.advance();
  }

 private:
  const Watch& watch_;
};

// Hidden ones, and what another run is just writing, are left out.
Result<std::vector<std::string>> names_in(const fs::path& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error))
    return fail(ErrorCode::NotFound, text(folder.string(), " is no folder of photographs"));
  std::vector<std::string> names;
  for (fs::recursive_directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    const bool hidden = at->path().filename().string().starts_with(".");
    std::error_code ignored;
    if (at->is_directory(ignored)) {
      if (hidden) at.disable_recursion_pending();
    } else if (!hidden && has_name_of_photo(at->path())) {
      names.push_back(at->path().lexically_relative(folder).generic_string());
    }
  }
  if (error) return fail(ErrorCode::Io, text(folder.string(), ": ", error.message()));
  if (names.empty())
    return fail(ErrorCode::NotFound,
                text(folder.string(), " has no photographs: no .jpg, .png or .tif in it"));
  std::sort(names.begin(), names.end());
  return names;
}

struct Read {
  Photo photo;
  PhotoFeatures features;
  std::string fault;
};

Read read_photo(const fs::path& folder, const std::string& name, const RelationCache& cache) {
  Read read;
  read.photo.name = name;
  const fs::path file = folder / name;
  const Result<std::string> bytes = read_file(file);
  if (!bytes) {
    read.fault = bytes.error().message;
    return read;
  }
  read.photo.hash = content_hash(*bytes);
  std::optional<PhotoFeatures> features = cache.features(read.photo.hash);
  if (!features) {
    const Result<Image> picture = decode_photo(*bytes, file.string());
    if (!picture) {
      read.fault = picture.error().message;
      return read;
    }
    features = find_features(*picture);
    cache.keep(read.photo.hash, *features);
  }
  read.photo.width = features->width;
  read.photo.height = features->height;
  read.photo.features = features->count();
  read.features = std::move(*features);
  return read;
}

Unexpected interrupted(const RelationOptions& options) {
  return fail(ErrorCode::Cancelled, options.cache.empty() ? "interrupted; nothing was written"
                                                          : text("interrupted; what was found so far is in ",
                                                                 options.cache.string()));
}

struct PairOfPhotos {
  std::size_t a, b;
};

// Both directions of those pairs of which one is not in the cache.
bool relate_missing(const std::vector<PhotoFeatures>& features, const std::vector<PairOfPhotos>& missing,
                    const RelationOptions& options, PhotoRelations& out) {
  const Part part(options.watch, "pairs", missing.size());
  const std::size_t n = features.size();
  std::vector<char> done(missing.size(), 0);
  parallel_for(missing.size(), options.threads, [&](std::size_t i) {
    if (options.watch.is_cancelled()) return;
    const auto [a, b] = missing[i];
    const NearestBothWays nearest = nearest_both_ways(features[a], features[b]);
    out.pairs[a * n + b] = relate(features[a], features[b], nearest.of_a);
    out.pairs[b * n + a] = relate(features[b], features[a], nearest.of_b);
    done[i] = 1;
    part.advance();
  });
  for (std::size_t i = 0; i < done.size(); ++i)
    if (done[i] != 0) ++out.matched;
  for (std::size_t i = 0; i < done.size(); ++i)
    if (done[i] == 0) {
      out.pairs[missing[i].a * n + missing[i].b].matches = -1;  // not to be kept
      out.pairs[missing[i].b * n + missing[i].a].matches = -1;
    }
  return out.matched == missing.size();
}

PairRows rows_of(const PhotoRelations& relations, PairRows rows) {
  const std::size_t n = relations.photos.size();
  for (std::size_t c = 0; c < n; ++c)
    for (std::size_t p = 0; p < n; ++p)
      if (const PairRelation& r = relations.pair(c, p); c != p && r.matches >= 0)
        rows[{relations.photos[c].hash, relations.photos[p].hash}] = r;
  return rows;
}

}  // namespace

Result<PhotoRelations> relate_photos(const fs::path& folder, const RelationOptions& options) {
  const Result<std::vector<std::string>> names = names_in(folder);
  if (!names) return forward(names);
  if (!options.cache.empty())
    if (Result<void> ok = make_folder(options.cache); !ok) return forward(ok);
  RelationCache cache(options.cache);
  std::vector<Read> reads(names->size());
  {
    const Part part(options.watch, "features", names->size());
    parallel_for(names->size(), options.threads, [&](std::size_t i) {
      if (options.watch.is_cancelled()) return;
      reads[i] = read_photo(folder, (*names)[i], cache);
      part.advance();
    });
  }
  if (options.watch.is_cancelled()) return interrupted(options);
  PhotoRelations out;
  std::vector<PhotoFeatures> features;
  for (Read& read : reads) {
    if (!read.fault.empty()) {
      out.unread.push_back({read.photo.name, read.fault});
      continue;
    }
    out.photos.push_back(std::move(read.photo));
    features.push_back(std::move(read.features));
  }
  if (out.photos.empty())
    return fail(ErrorCode::BadData, text(folder.string(), ": none of ", names->size(),
                                         " photographs can be read; ", out.unread.front().why));
  const std::size_t n = out.photos.size();
  out.pairs.resize(n * n);
  std::vector<PairOfPhotos> missing;
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = a + 1; b < n; ++b) {
      const auto there = cache.rows().find({out.photos[a].hash, out.photos[b].hash}),
                 back = cache.rows().find({out.photos[b].hash, out.photos[a].hash});
      if (there == cache.rows().end() || back == cache.rows().end()) {
        missing.push_back({a, b});
        continue;
      }
      out.pairs[a * n + b] = there->second;
      out.pairs[b * n + a] = back->second;
    }
  const bool whole = relate_missing(features, missing, options, out);
  if (out.matched > 0)
    if (Result<void> ok = cache.keep(rows_of(out, cache.rows())); !ok) return forward(ok);
  if (!whole) return interrupted(options);
  return out;
}

}  // namespace floatstage::detail
