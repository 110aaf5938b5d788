#include "pipeline/stills/placed_stills.h"

#include <algorithm>
#include <cstdio>
#include <map>

#include <nlohmann/json.hpp>

#include "core/file.h"
#include "core/png.h"
#include "core/text.h"
#include "detail/photo_file.h"
#include "detail/photo_graph.h"
#include "detail/photo_relations.h"
#include "pipeline/confined_outputs.h"
#include "pipeline/detail_watch.h"
#include "pipeline/json_report.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kStills = "stills/";
constexpr std::uint8_t kBackdrop = 128;

std::string camera_name(std::size_t camera) {
  char name[32];
  std::snprintf(name, sizeof name, "camera-%04zu.png", camera);
  return name;
}

// The subject alone before grey.
Image subject_alone(const Image& picture, const Image& matte) {
  if (matte.empty()) return picture;
  Image alone = picture;
  for (std::size_t i = 0; i < matte.pixels.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      std::uint8_t& value = alone.pixels[3 * i + k];
      value = static_cast<std::uint8_t>(
          (value * matte.pixels[i] + kBackdrop * (255 - matte.pixels[i]) + 127) / 255);
    }
  return alone;
}

// Copies what may be a photograph; neither devices nor what a link leads out to is opened by the graph.
Result<std::size_t> copy_stills(const fs::path& from, const fs::path& to) {
  std::error_code error;
  if (!fs::is_directory(from, error))
    return fail(ErrorCode::NotFound, text("--stills ", from.string(), ": there is no such folder"));
  std::vector<fs::path> files;
  for (fs::recursive_directory_iterator it(from, error), end; !error && it != end; it.increment(error)) {
    const bool hidden = it->path().filename().string().starts_with('.');
    if (it->is_directory(error)) {
      if (hidden) it.disable_recursion_pending();
    } else if (!hidden && detail::has_name_of_photo(it->path()) && it->is_regular_file(error)) {
      files.push_back(it->path());
    }
  }
  if (error) return fail(ErrorCode::Io, text("cannot read ", from.string(), ": ", error.message()));
  if (files.empty())
    return fail(ErrorCode::NotFound,
                text("--stills ", from.string(), ": there is no photograph in it (.jpg, .png, .tif)"));
  for (const fs::path& file : files) {
    const fs::path copy = to / fs::relative(file, from, error);
    if (Result<void> ok = make_folder(copy.parent_path()); !ok) return forward(ok);
    const Result<std::string> bytes = read_file(file);
    if (!bytes) return forward(bytes);
    if (Result<void> ok = write_file(copy, *bytes); !ok) return forward(ok);
  }
  return files.size();
}

// What one camera's photograph and all stills are to one another.
detail::PhotoRelations of_one_camera(const detail::PhotoRelations& all, std::size_t camera) {
  detail::PhotoRelations some;
  std::vector<std::size_t> kept = {camera};
  for (std::size_t i = 0; i < all.photos.size(); ++i)
    if (all.photos[i].name.starts_with(kStills)) kept.push_back(i);
  for (const std::size_t i : kept) some.photos.push_back(all.photos[i]);
  for (const std::size_t child : kept)
    for (const std::size_t parent : kept) some.pairs.push_back(all.pair(child, parent));
  return some;
}

// Why a still has no place: what the photograph says in which most of it was found again.
std::string why_refused(const detail::PhotoRelations& all, std::size_t still, const StraightInstant& instant,
                        const std::map<std::string, std::size_t>& camera_of) {
  std::size_t best = all.photos.size();
  for (const auto& [name, camera] : camera_of)
    for (std::size_t p = 0; p < all.photos.size(); ++p)
      if (all.photos[p].name == name &&
          (best == all.photos.size() || all.pair(still, p).matches > all.pair(still, best).matches))
        best = p;
  if (best == all.photos.size()) return "no camera's photograph could be read";
  const detail::PairRelation& pair = all.pair(still, best);
  const std::string& serial = instant.rig.cameras[camera_of.at(all.photos[best].name)].serial;
  return text("camera '", serial, "' is nearest, and there: ",
              pair.contained() ? "the photograph has as many pixels of it" : pair.why);
}

// What the child tells its parent: places and refusals; decoded stills lie beside it.
json relate(const detail::PhotoRelations& all, const StraightInstant& instant) {
  std::map<std::string, std::size_t> camera_of;
  for (std::size_t c = 0; c < instant.rig.cameras.size(); ++c) camera_of[camera_name(c)] = c;
  json places = json::array(), refused = json::array();
  std::map<std::string, bool> placed;
  for (std::size_t i = 0; i < all.photos.size(); ++i) {
    const auto camera = camera_of.find(all.photos[i].name);
    if (camera == camera_of.end()) continue;
    const detail::PhotoRelations some = of_one_camera(all, i);
    const Result<detail::PhotoGraph> graph = detail::choose_parents(some, all.photos[i].name);
    if (!graph) continue;  // it was read, so that its name is there
    for (const int below : graph->descendants(graph->root)) {
      Eigen::Matrix3d root_from_still = Eigen::Matrix3d::Identity();
      double zoom = 1;
      for (int at = below; at != graph->root; at = graph->photos[static_cast<std::size_t>(at)].parent) {
        const detail::GraphPhoto& photo = graph->photos[static_cast<std::size_t>(at)];
        root_from_still = photo.parent_from_child * root_from_still;
        zoom *= photo.zoom;
      }
      const std::string& name = graph->photos[static_cast<std::size_t>(below)].photo.name;
      placed[name] = true;
      std::vector<double> h(root_from_still.data(), root_from_still.data() + 9);
      places.push_back({{"still", name}, {"camera", camera->second}, {"h", h}, {"zoom", zoom}});
    }
  }
  for (std::size_t i = 0; i < all.photos.size(); ++i) {
    const std::string& name = all.photos[i].name;
    if (name.starts_with(kStills) && !placed.contains(name))
      refused.push_back({{"name", name}, {"why", why_refused(all, i, instant, camera_of)}});
  }
  for (const detail::UnreadPhoto& unread : all.unread)
    refused.push_back({{"name", unread.name}, {"why", unread.why}});
  json names = json::array();
  for (const auto& [name, there] : placed) names.push_back(name);
  return {{"stills", names}, {"places", places}, {"refused", refused}};
}

std::string file_of(std::size_t still) { return text("still-", still, ".png"); }

Result<void> place(const StraightInstant& instant, const PlaceStillsOptions& options, const fs::path& out,
                   Progress* told) {
  const fs::path photos = out / "photos";
  if (Result<void> ok = make_folder(photos); !ok) return ok;
  const Result<std::size_t> count = copy_stills(options.folder, photos / kStills);
  if (!count) return forward(count);
  for (std::size_t c = 0; c < instant.pictures.size(); ++c)
    if (Result<void> ok =
            save_png(subject_alone(instant.pictures[c], instant.mattes[c]), photos / camera_name(c));
        !ok)
      return ok;
  detail::RelationOptions relation;
  relation.threads = options.threads;
  if (told) relation.watch = watched_by(*told);
  const Result<detail::PhotoRelations> all = detail::relate_photos(photos, relation);
  if (!all) return forward(all);
  const json report = relate(*all, instant);
  for (std::size_t s = 0; s < report["stills"].size(); ++s) {
    const Result<Image> picture = detail::load_photo(photos / report["stills"][s].get<std::string>());
    if (!picture) return forward(picture);
    if (Result<void> ok = save_png(*picture, out / file_of(s)); !ok) return ok;
  }
  std::error_code ignored;
  fs::remove_all(photos, ignored);
  return save_json(report, out / "places.json");
}

std::string without_prefix(const std::string& name) {
  return name.starts_with(kStills) ? name.substr(std::string(kStills).size()) : name;
}

// The child's word, which is foreign: it read foreign files.
Result<PlacedStills> read_places(const fs::path& folder, const StraightInstant& instant) {
  const Result<std::string> bytes = read_file(folder / "places.json");
  if (!bytes) return forward(bytes);
  const json report = json::parse(*bytes, nullptr, /*allow_exceptions=*/false);
  PlacedStills placed;
  try {
    std::map<std::string, std::size_t> index;
    for (const json& name : report.at("stills")) {
      Result<Image> picture = load_png(folder / file_of(placed.stills.size()));
      if (!picture) return forward(picture);
      if (picture->channels != 3)
        return fail(ErrorCode::BadData, text(name.get<std::string>(), ": is not RGB"));
      index[name.get<std::string>()] = placed.stills.size();
      placed.stills.push_back({without_prefix(name.get<std::string>()), std::move(*picture)});
    }
    for (const json& p : report.at("places")) {
      StillPlace place;
      place.still = index.at(p.at("still").get<std::string>());
      place.camera = p.at("camera").get<std::size_t>();
      const auto h = p.at("h").get<std::vector<double>>();
      place.zoom = p.at("zoom").get<double>();
      if (h.size() != 9 || place.camera >= instant.rig.cameras.size() || !(place.zoom > 0))
        return fail(ErrorCode::BadData, "what relates the stills gave a place that makes no sense");
      place.photo_from_still = Eigen::Map<const Eigen::Matrix3d>(h.data());
      placed.places.push_back(place);
    }
    for (const json& r : report.at("refused"))
      placed.refused.push_back(
          {without_prefix(r.at("name").get<std::string>()), r.at("why").get<std::string>()});
  } catch (const std::exception&) {
    return fail(ErrorCode::BadData, "what relates the stills gave a report that cannot be read");
  }
  std::stable_sort(placed.places.begin(), placed.places.end(), [](const StillPlace& a, const StillPlace& b) {
    return a.still != b.still ? a.still < b.still : a.camera < b.camera;
  });
  return placed;
}

}  // namespace

Result<PlacedStills> place_stills(const StraightInstant& instant, const PlaceStillsOptions& options) {
  const fs::path out = options.scratch / "placed";
  if (Result<void> ok = make_confined({.what = options.folder.string(), .outputs = {out}}, options.progress,
                                      [&](const PlaceOf& place_of, Progress* told) {
                                        return place(instant, options, place_of(out), told);
                                      });
      !ok)
    return forward(ok);
  return read_places(out, instant);
}

}  // namespace floatstage::pipeline
