// Method:  silhouettes closed and opened by squares, until their hull has few enough handles
// ADR:     0264

#include "recon/small_budget.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "core/parallel.h"
#include "core/text.h"
#include "recon/mask_distance.h"
#include "recon/mesh/hull_cleanup.h"
#include "recon/mesh/mesh_silhouettes.h"

namespace floatstage::recon {
namespace {

constexpr double kMuch = 0.05;       // of a silhouette's IoU: more is lost than simpler silhouettes cost
constexpr int kFinest = 2;           // px: half of what closes, doubled in each attempt …
constexpr double kCoarsest = 0.025;  // … up to so much of the longer side: a real hole is no gap

// Pixels of a line within `reach` of one that is `value` become it.
void spread(std::vector<std::uint8_t>& line, std::vector<std::uint8_t>& scratch, int reach, bool value) {
  const int n = static_cast<int>(line.size());
  scratch = line;
  int last = -reach - 1;
  for (int i = 0; i < n; ++i) {
    const auto at = static_cast<std::size_t>(i);
    if ((line[at] != 0) == value) last = i;
    if (i - last <= reach) scratch[at] = value;
  }
  last = n + reach;
  for (int i = n - 1; i >= 0; --i) {
    const auto at = static_cast<std::size_t>(i);
    if ((line[at] != 0) == value) last = i;
    if (last - i <= reach) scratch[at] = value;
  }
  line.swap(scratch);
}

// Subject (or background) grown by a square.
void grow(Image& mask, int reach, bool subject) {
  std::vector<std::uint8_t> line, scratch;
  for (int y = 0; y < mask.height; ++y) {
    line.assign(mask.at(0, y), mask.at(0, y) + mask.width);
    spread(line, scratch, reach, subject);
    std::copy(line.begin(), line.end(), mask.at(0, y));
  }
  for (int x = 0; x < mask.width; ++x) {
    line.clear();
    for (int y = 0; y < mask.height; ++y) line.push_back(*mask.at(x, y));
    spread(line, scratch, reach, subject);
    for (int y = 0; y < mask.height; ++y) *mask.at(x, y) = line[static_cast<std::size_t>(y)];
  }
}

Matte simpler(const Matte& matte, int reach) {
  if (matte.empty()) return matte;
  Image mask = to_image(matte);
  for (std::uint8_t& a : mask.pixels) a = a >= 128;
  for (const bool subject : {true, false, false, true}) grow(mask, reach, subject);  // closed, then opened
  for (std::uint8_t& a : mask.pixels) a = a ? 255 : 0;
  return make_matte(matte.source, mask);
}

double worst_loss(const MeshCleanupReport& done) {
  return done.iou_loss.empty() ? 0 : *std::max_element(done.iou_loss.begin(), done.iou_loss.end());
}

/// What clean-up did, against the hull as it was.
void measure(const Rig& rig, std::span<const Matte> mattes, const Mesh& raw, const Mesh& mesh, int threads,
             MeshCleanupReport& done) {
  done.triangles_before = raw.triangle_count();
  done.iou_loss.assign(mattes.size(), 0);
  done.silhouette_shift.assign(mattes.size(), 0);
  const MeshSilhouettes of_raw(raw), of_mesh(mesh);
  parallel_for(mattes.size(), threads, [&](std::size_t c) {
    if (mattes[c].empty()) return;
    const Matte before = of_raw.of(rig.cameras[c]), after = of_mesh.of(rig.cameras[c]);
    done.iou_loss[c] = iou(before, mattes[c]) - iou(after, mattes[c]);
    done.silhouette_shift[c] = mask_distance(before, after);
  });
  done.vertex_move = done.silhouette_shift;  // no vertex is where one was
}

}  // namespace

Result<void> meet_budget(const Rig& rig, std::span<const Matte> mattes, const HullOptions& options,
                         const Mesh& raw, HullReport& report) {
  const auto budget = static_cast<std::size_t>(options.cleanup.triangles);
  const bool fits = report.cleanup->triangles_after <= budget;
  if (fits && worst_loss(*report.cleanup) <= kMuch) return {};
  HullOptions plain = options;
  plain.cleanup = {};
  plain.quality = false;
  std::vector<Matte> simple(mattes.size());
  int longest = 0;
  for (const Matte& m : mattes) longest = std::max({longest, m.width, m.height});
  for (int reach = kFinest; reach <= kCoarsest * longest; reach *= 2) {
    parallel_for(mattes.size(), options.threads,
                 [&](std::size_t c) { simple[c] = simpler(mattes[c], reach); });
    Result<HullReport> hull = visual_hull(rig, simple, plain);
    if (!hull) return forward(hull);
    if (hull->mesh.empty()) return {};
    clean_up_hull(rig, mattes, options, *hull);
    if (!hull->cleanup || hull->cleanup->triangles_after > budget) continue;
    measure(rig, mattes, raw, hull->mesh, options.threads, *hull->cleanup);
    if (fits && worst_loss(*hull->cleanup) >= worst_loss(*report.cleanup)) return {};
    std::erase_if(report.remarks, [](const std::string& r) { return r.starts_with("decimation stopped"); });
    report.remarks.push_back(
        text("so few triangles hold no loops of hair and no gaps between fingers: what is narrower than ",
             2 * reach, " px was taken out of the silhouettes for them"));
    report.mesh = std::move(hull->mesh);
    report.sources = std::move(hull->sources);
    report.volume = hull->volume;
    report.cleanup = std::move(hull->cleanup);
    return {};
  }
  return {};
}

}  // namespace floatstage::recon
