#include "pipeline/matte/hull_agreement.h"

#include <algorithm>

#include "core/parallel.h"
#include "core/text.h"
#include "pipeline/progress.h"
#include "pipeline/scene_loader.h"
#include "recon/mesh/mesh_mask.h"
#include "recon/visual_hull.h"

namespace floatstage::pipeline {
namespace {

bool shows_subject(const Matte& matte) { return !matte.empty() && coverage(matte) > 0; }

constexpr int kOutlineSlack = 2;  // px that outlines of photographs are off by, and then some

// Whether the picture has subject within `reach` pixels, by squares.
bool has_subject_near(const Matte& m, int x, int y, int reach) {
  for (int v = std::max(0, y - reach); v <= std::min(m.height - 1, y + reach); ++v)
    for (int u = std::max(0, x - reach); u <= std::min(m.width - 1, x + reach); ++u)
      if (m.row(v)[u] >= 128) return true;
  return false;
}

// Share of `matte` that lies farther than `slack` pixels outside of `hull`.
double share_outside(const Matte& matte, const Matte& hull, int slack) {
  std::size_t all = 0, outside = 0;
  for (int y = 0; y < matte.height; ++y)
    for (int x = 0; x < matte.width; ++x) {
      if (matte.row(y)[x] < 128) continue;
      ++all;
      outside += !has_subject_near(hull, x, y, slack);
    }
  return all ? static_cast<double>(outside) / static_cast<double>(all) : 0;
}

Result<std::vector<SilhouetteAgreement>> agreement_of(const capture::TakeReader& take, int frame) {
  Result<std::vector<Matte>> mattes = load_mattes(take, frame);
  if (!mattes) return forward(mattes);
  return agreement_between(take.rig(), *mattes, frame);
}

}  // namespace

double denied_share(const Matte& matte, const Matte& hull) {
  return share_outside(matte, hull, kOutlineSlack);
}

std::optional<Matte> silhouette_of_others(const Rig& rig, const std::vector<Matte>& mattes,
                                          std::size_t camera) {
  std::vector<Matte> others = mattes;
  others[camera] = {};
  if (std::count_if(others.begin(), others.end(), shows_subject) < 2) return std::nullopt;
  recon::HullOptions options;
  options.quality = false;
  options.threads = 1;
  const Result<recon::HullReport> hull = recon::visual_hull(rig, others, options);
  if (!hull) return std::nullopt;  // they bound no space
  return recon::mesh_mask(rig.cameras[camera], hull->mesh);
}

std::vector<SilhouetteAgreement> agreement_between(const Rig& rig, const std::vector<Matte>& mattes,
                                                   int frame) {
  std::vector<SilhouetteAgreement> found;
  for (std::size_t i = 0; i < mattes.size(); ++i) {
    if (mattes[i].empty()) continue;
    const std::optional<Matte> silhouette = silhouette_of_others(rig, mattes, i);
    if (!silhouette) continue;  // nothing to compare with
    SilhouetteAgreement a{rig.cameras[i].serial, frame, 0, 1, 1};
    if (shows_subject(*silhouette)) {
      a.iou = iou(mattes[i], *silhouette);
      a.surplus = share_outside(mattes[i], *silhouette, 0);
      a.denied = denied_share(mattes[i], *silhouette);
    } else {
      a.iou = shows_subject(mattes[i]) ? 0 : 1;  // the others agree on nothing at all
    }
    found.push_back(std::move(a));
  }
  return found;
}

Result<std::vector<SilhouetteAgreement>> hull_agreement(const capture::TakeReader& take,
                                                        const std::vector<int>& frames, int threads,
                                                        Progress* watch) {
  std::vector<Result<std::vector<SilhouetteAgreement>>> by_frame(frames.size(),
                                                                 std::vector<SilhouetteAgreement>());
  ProgressPart progress(watch, "hull check", frames.size());
  parallel_for(frames.size(), threads, [&](std::size_t i) {
    if (!is_cancelled(watch)) by_frame[i] = agreement_of(take, frames[i]);
    progress.advance();
  });
  if (is_cancelled(watch)) return cancelled();
  std::vector<SilhouetteAgreement> all;
  for (Result<std::vector<SilhouetteAgreement>>& found : by_frame) {
    if (!found) return forward(found);
    all.insert(all.end(), found->begin(), found->end());
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const SilhouetteAgreement& a, const SilhouetteAgreement& b) { return a.iou < b.iou; });
  return all;
}

}  // namespace floatstage::pipeline
