#include "pipeline/matte/hull_agreement.h"

#include <algorithm>

#include "core/parallel.h"
#include "pipeline/scene_loader.h"

namespace floatstage::pipeline {
namespace {

Result<std::vector<recon::SilhouetteAgreement>> agreement_of(const capture::TakeReader& take, int frame) {
  Result<std::vector<Matte>> mattes = load_mattes(take, frame);
  if (!mattes) return forward(mattes);
  return recon::agreement_between(take.rig(), *mattes, frame);
}

}  // namespace

Result<std::vector<recon::SilhouetteAgreement>> hull_agreement(const capture::TakeReader& take,
                                                               const std::vector<int>& frames, int threads,
                                                               Progress* watch) {
  std::vector<Result<std::vector<recon::SilhouetteAgreement>>> by_frame(
      frames.size(), std::vector<recon::SilhouetteAgreement>());
  ProgressPart progress(watch, "hull check", frames.size());
  parallel_for(frames.size(), threads, [&](std::size_t i) {
    if (!is_cancelled(watch)) by_frame[i] = agreement_of(take, frames[i]);
    progress.advance();
  });
  if (is_cancelled(watch)) return cancelled();
  std::vector<recon::SilhouetteAgreement> all;
  for (Result<std::vector<recon::SilhouetteAgreement>>& found : by_frame) {
    if (!found) return forward(found);
    all.insert(all.end(), found->begin(), found->end());
  }
  std::stable_sort(
      all.begin(), all.end(),
      [](const recon::SilhouetteAgreement& a, const recon::SilhouetteAgreement& b) { return a.iou < b.iou; });
  return all;
}

}  // namespace floatstage::pipeline
