#include "apps/hull_flags.h"

#include <algorithm>

namespace floatstage::apps {

std::vector<const CLI::Option*> add_care_flags(CLI::App& verb, recon::MeshCleanup& care) {
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
  recon::HullOptions& options = flags.options;
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

}  // namespace floatstage::apps
