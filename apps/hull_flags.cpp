#include "apps/hull_flags.h"

#include <algorithm>
#include <charconv>

#include <nlohmann/json.hpp>

#include "core/text.h"

namespace floatstage {

std::vector<const CLI::Option*> add_care_flags(CLI::App& verb, HullCare& care) {
  return {verb.add_flag("--collapse-slivers", care.collapse_slivers,
                        "Care: collapse needles and caps where no vertex has to move by more than "
                        "--care-pixels in any view"),
          verb.add_option("--smooth", care.smooth,
                          "Care: rounds of smoothing, every vertex within --care-pixels in every view")
              ->capture_default_str(),
          verb.add_option("--triangles", care.triangles,
                          "Care: collapse the least important edges until so few triangles are left; 0: none")
              ->capture_default_str(),
          verb.add_option("--care-pixels", care.largest_move,
                          "Care: how far from where it was any vertex may be seen, pixels")
              ->capture_default_str(),
          verb.add_option("--care-loss", care.largest_loss,
                          "Care: of any silhouette's IoU, the most that smoothing may cost")
              ->capture_default_str()};
}

void add_hull_flags(CLI::App& verb, HullFlags& flags) {
  HullOptions& options = flags.options;
  const auto add = [&](const char* name, auto& value, const char* help) {
    CLI::Option* word = verb.add_option(name, value, help);
    flags.words.push_back(word);
    return word;
  };
  add("--method", flags.method, "exact (the silhouettes' polyhedron) or octree (soft, slow, the reference)")
      ->capture_default_str();
  add("--contour-tolerance", options.contour_tolerance,
      "Exact: pixels by which the polygons may leave the silhouettes; 0 keeps every point")
      ->capture_default_str();
  add("--votes", flags.votes,
      "Exact: strict (all cameras agree), auto (a camera whose matte lacks a part is left out), or how many "
      "cameras have to agree")
      ->capture_default_str();
  add("--resolution", options.resolution, "Octree: voxels along the hull's longest side")
      ->capture_default_str();
  add("--smoothing", options.smoothing, "Octree: largest move of a vertex by smoothing, in voxels")
      ->capture_default_str();
  add("--volume", flags.volume,
      "World box of the stage, metres: x0 y0 z0 x1 y1 z1 (default: from the silhouettes)")
      ->expected(6);
  const std::vector<const CLI::Option*> care = add_care_flags(verb, options.care);
  flags.words.insert(flags.words.end(), care.begin(), care.end());
}

bool HullFlags::given() const {
  return std::any_of(words.begin(), words.end(), [](const CLI::Option* word) { return word->count() > 0; });
}

Result<HullOptions> hull_options(const HullFlags& flags) {
  HullOptions options = flags.options;
  if (flags.method == "exact") {
    options.method = HullMethod::Exact;
  } else if (flags.method == "octree") {
    options.method = HullMethod::Octree;
  } else {
    return fail(ErrorCode::InvalidArgument,
                text("--method '", flags.method, "' is neither exact nor octree"));
  }
  if (flags.votes == "strict") {
    options.voting = HullVoting::Strict;
  } else if (flags.votes == "auto") {
    options.voting = HullVoting::Auto;
  } else {
    options.voting = HullVoting::MofN;
    const char* end = flags.votes.data() + flags.votes.size();
    const auto [stop, error] = std::from_chars(flags.votes.data(), end, options.votes);
    if (error != std::errc() || stop != end || options.votes < 2) {
      return fail(
          ErrorCode::InvalidArgument,
          text("--votes '", flags.votes, "' is neither strict, auto nor a number of at least 2 cameras"));
    }
  }
  if (!flags.volume.empty()) {
    options.volume = Eigen::AlignedBox3d(Eigen::Vector3d(flags.volume[0], flags.volume[1], flags.volume[2]),
                                         Eigen::Vector3d(flags.volume[3], flags.volume[4], flags.volume[5]));
  }
  if (Result<void> ok = check(options); !ok) return forward(ok);
  return options;
}

nlohmann::json describe(const HullOptions& options) {
  nlohmann::json j;
  if (options.method == HullMethod::Octree) {
    j = {{"method", "octree"}, {"resolution", options.resolution}, {"smoothing", options.smoothing}};
  } else {
    j = {{"method", "exact"}, {"contour_tolerance", options.contour_tolerance}};
    if (options.voting == HullVoting::MofN) {
      j["votes"] = options.votes;
    } else {
      j["votes"] = options.voting == HullVoting::Auto ? "auto" : "strict";
    }
  }
  if (options.volume) {
    const Eigen::Vector3d a = options.volume->min(), b = options.volume->max();
    j["volume"] = {a.x(), a.y(), a.z(), b.x(), b.y(), b.z()};
  }
  if (options.care.wanted()) {
    const HullCare& care = options.care;
    j["care"] = {{"collapse_slivers", care.collapse_slivers},
                 {"smooth", care.smooth},
                 {"triangles", care.triangles},
                 {"pixels", care.largest_move},
                 {"loss", care.largest_loss}};
  }
  return j;
}

std::optional<HullOptions> parse_hull_options(const nlohmann::json& description) {
  try {
    const nlohmann::json& j = description;
    HullFlags flags;
    flags.method = j.at("method").get<std::string>();
    flags.options.resolution = j.value("resolution", flags.options.resolution);
    flags.options.smoothing = j.value("smoothing", flags.options.smoothing);
    flags.options.contour_tolerance = j.value("contour_tolerance", flags.options.contour_tolerance);
    if (j.contains("votes"))
      flags.votes = j["votes"].is_string() ? j["votes"].get<std::string>() : j["votes"].dump();
    if (j.contains("volume")) flags.volume = j["volume"].get<std::vector<double>>();
    if (j.contains("care")) {
      HullCare& care = flags.options.care;
      const nlohmann::json& c = j["care"];
      care.collapse_slivers = c.value("collapse_slivers", care.collapse_slivers);
      care.smooth = c.value("smooth", care.smooth);
      care.triangles = c.value("triangles", care.triangles);
      care.largest_move = c.value("pixels", care.largest_move);
      care.largest_loss = c.value("loss", care.largest_loss);
    }
    if (!flags.volume.empty() && flags.volume.size() != 6) return std::nullopt;
    Result<HullOptions> options = hull_options(flags);
    if (!options) return std::nullopt;
    return *options;
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;  // a word that is missing or of another kind
  }
}

}  // namespace floatstage
