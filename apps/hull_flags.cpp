#include "apps/hull_flags.h"

#include <charconv>

#include <nlohmann/json.hpp>

#include "core/text.h"

namespace floatstage {

void add_hull_flags(CLI::App& verb, HullFlags& flags) {
  HullOptions& options = flags.options;
  verb.add_option("--method", flags.method,
                  "exact (the silhouettes' polyhedron) or octree (soft, slow, the reference)")
      ->capture_default_str();
  verb.add_option("--contour-tolerance", options.contour_tolerance,
                  "Exact: pixels by which the polygons may leave the silhouettes; 0 keeps every point")
      ->capture_default_str();
  verb.add_option(
          "--votes", flags.votes,
          "Exact: strict (all cameras agree), auto (a camera whose matte lacks a part is left out), or how "
          "many cameras have to agree")
      ->capture_default_str();
  verb.add_option("--resolution", options.resolution, "Octree: voxels along the hull's longest side")
      ->capture_default_str();
  verb.add_option("--smoothing", options.smoothing,
                  "Octree: largest move of a vertex by smoothing, in voxels")
      ->capture_default_str();
  verb.add_option("--volume", flags.volume,
                  "World box of the stage, metres: x0 y0 z0 x1 y1 z1 (default: from the silhouettes)")
      ->expected(6);
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
  return j;
}

}  // namespace floatstage
