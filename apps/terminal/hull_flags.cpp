#include "apps/terminal/hull_flags.h"

#include <algorithm>

#include "apps/terminal/flags.h"

namespace floatstage::apps {
namespace {

std::vector<const CLI::Option*> add_cleanup_flags(CLI::App& verb, recon::MeshCleanup& cleanup) {
  const std::vector<CLI::Option*> words = {
      verb.add_flag(
          "--collapse-slivers", cleanup.collapse_slivers,
          "Collapse needles and caps where no vertex has to move by more than --cleanup-pixels in any "
          "view"),
      verb.add_option("--smooth", cleanup.smooth,
                      "Rounds of smoothing, every vertex within --cleanup-pixels in every view")
          ->capture_default_str(),
      verb.add_option("--triangles", cleanup.triangles,
                      "Collapse the least important edges until so few triangles are left; 0: none")
          ->capture_default_str(),
      verb.add_option("--cleanup-pixels", cleanup.largest_move,
                      "How far from where it was any vertex may be seen, pixels")
          ->capture_default_str(),
      verb.add_option("--cleanup-loss", cleanup.largest_loss,
                      "Of any silhouette's IoU, the most that smoothing may cost")
          ->capture_default_str()};
  for (CLI::Option* word : words) word->group(kGroupCleanup);
  return {words.begin(), words.end()};
}

}  // namespace

void add_hull_flags(CLI::App& verb, HullFlags& flags) {
  recon::HullOptions& options = flags.options;
  const auto add = [&](const char* name, auto& value, const char* group, const char* help) {
    CLI::Option* word = verb.add_option(name, value, help)->group(group);
    flags.words.push_back(word);
    return word;
  };
  add("--hull", flags.method, kGroupHull,
      "exact (the silhouettes' polyhedron) or octree (soft, slow, the reference)")
      ->capture_default_str()
      ->check(one_of({"exact", "octree"}));
  add("--votes", flags.votes, kGroupHull,
      "Exact: strict (all cameras agree), auto (where a matte lacks what the others see, it is overruled), "
      "or "
      "how many cameras have to agree")
      ->capture_default_str();
  add("--volume", flags.volume, kGroupHull,
      "World box of the stage, metres: x0 y0 z0 x1 y1 z1 (default: from the silhouettes)")
      ->expected(6);
  add("--contour-tolerance", options.contour_tolerance, kGroupTuning,
      "Exact: pixels by which the polygons may leave the silhouettes; 0 keeps every point")
      ->capture_default_str();
  add("--resolution", options.resolution, kGroupTuning, "Octree: voxels along the hull's longest side")
      ->capture_default_str();
  add("--smoothing", options.smoothing, kGroupTuning,
      "Octree: largest move of a vertex by smoothing, in voxels")
      ->capture_default_str();
  flags.words.push_back(verb.add_flag("--keep-crumbs", options.keep_crumbs,
                                      "Exact: keep pieces thinner than the mattes are sure of, too")
                            ->group(kGroupHull));
  const std::vector<const CLI::Option*> cleanup = add_cleanup_flags(verb, options.cleanup);
  flags.words.insert(flags.words.end(), cleanup.begin(), cleanup.end());
}

bool HullFlags::given() const {
  return std::any_of(words.begin(), words.end(), [](const CLI::Option* word) { return word->count() > 0; });
}

}  // namespace floatstage::apps
