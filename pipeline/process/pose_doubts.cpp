#include "pipeline/process/pose_doubts.h"

#include <algorithm>
#include <iterator>

#include "core/text.h"
#include "pipeline/silhouettes/asked_instants.h"
#include "pipeline/silhouettes/silhouette_check.h"

namespace floatstage::pipeline {
namespace {

constexpr std::size_t kFewestCameras = 5;

using Named = std::vector<SilhouetteCameraCheck>;

// Nobody where nobody is on stage.
Result<Named> named_in(const Rig& rig, const std::vector<InstantMattes>& instants,
                       const SilhouetteCheckOptions& options) {
  Named named;
  Result<SilhouetteCheck> check = check_silhouettes(rig, instants, options);
  if (!check && check.error().code == ErrorCode::NotFound) return named;
  if (!check) return forward(check);
  std::copy_if(check->cameras.begin(), check->cameras.end(), std::back_inserter(named),
               [](const SilhouetteCameraCheck& camera) { return camera.named; });
  return named;
}

}  // namespace

Result<std::vector<std::string>> pose_doubts(const capture::TakeReader& take, const std::vector<int>& frames,
                                             int threads, Progress* progress) {
  std::vector<std::string> doubts;
  if (take.rig().cameras.size() < kFewestCameras || frames.empty()) return doubts;
  const Result<AskedInstants> asked = asked_instants(take, frames, threads);
  if (!asked) return forward(asked);
  if (asked->mattes.empty()) return doubts;
  const SilhouetteCheckOptions options{.quick = true, .threads = threads, .progress = progress};
  const std::string folder = take.layout().folder().string();
  Result<Named> named = named_in(take.rig(), asked->mattes, options);
  if (!named) return forward(named);
  for (const SilhouetteCameraCheck& camera : *named)
    doubts.push_back(text(sentence(camera), "; `floatstage calibrate silhouettes ", folder,
                          " -o RIG` writes a corrected rig"));
  if (!doubts.empty() || asked->mattes.size() < 2) return doubts;
  // Both together hide a camera that was moved between them.
  named = named_in(take.rig(), {asked->mattes.back()}, options);
  if (!named) return forward(named);
  for (const SilhouetteCameraCheck& camera : *named)
    doubts.push_back(text(sentence(camera), " in frame ", asked->frames.back(), ", but not in frame ",
                          asked->frames.front(),
                          ": was it moved in between? `floatstage calibrate silhouettes ", folder,
                          " --frames A:B -o RIG` writes a rig for a part, `floatstage take trim` makes it"));
  return doubts;
}

}  // namespace floatstage::pipeline
