#include "pipeline/matte/heal_take.h"

#include <algorithm>

#include "capture/added_file.h"
#include "core/parallel.h"
#include "pipeline/hull_inside_bars.h"
#include "pipeline/hull_record.h"
#include "pipeline/scene_loader.h"

namespace floatstage::pipeline {
namespace {

constexpr std::ptrdiff_t kFewest = 3;  // two bound a body, the third confirms it: as kFewWitnesses

Result<void> heal_instant(const capture::TakeReader& take, int frame, const capture::AddedFile& added,
                          const recon::HullOptions& options, MatteHealer& healer) {
  Result<MatteHashes> hashes = hashes_of_mattes(take.layout(), take.rig(), frame);
  if (!hashes) return forward(hashes);
  if (healer.compared(frame, *hashes)) return {};
  Result<std::vector<Matte>> mattes = load_mattes(take, frame, &*hashes);
  if (!mattes) return forward(mattes);
  const auto shows_subject = [](const Matte& m) { return !m.empty() && coverage(m) > 0; };
  if (std::count_if(mattes->begin(), mattes->end(), shows_subject) < kFewest) return {};
  recon::HullWorkspace workspace;
  recon::HullReport hull;
  if (!hull_inside_bars(take.rig(), *mattes, added, options, workspace, hull) || hull.mesh.empty()) return {};
  const Result<bool> healed = healer.heal(frame, hull, options, *mattes, *hashes);
  if (!healed) return forward(healed);
  return {};
}

}  // namespace

Result<std::vector<HealedCamera>> heal_take(capture::TakeReader& take, const std::vector<int>& frames,
                                            int threads, Progress* watch) {
  Result<std::unique_ptr<MatteHealer>> healer = MatteHealer::open(take);
  if (!healer) return forward(healer);
  const Result<capture::AddedFile> added = capture::load_added(take.layout());
  if (!added) return forward(added);
  recon::HullOptions options = *hull_options(HullWords());
  options.quality_step = 4;                           // as `process`
  options.threads = frames.size() > 1 ? 1 : threads;  // over frames, or inside the one
  std::vector<Result<void>> done(frames.size());
  ProgressPart progress(watch, "silhouettes", frames.size());
  parallel_for(frames.size(), threads, [&](std::size_t i) {
    if (!is_cancelled(watch)) done[i] = heal_instant(take, frames[i], *added, options, **healer);
    progress.advance();
  });
  Result<std::vector<HealedCamera>> healed = (*healer)->finish();
  if (!healed) return healed;
  for (Result<void>& ok : done)
    if (!ok) return forward(ok);
  if (is_cancelled(watch)) return cancelled();
  return healed;
}

}  // namespace floatstage::pipeline
