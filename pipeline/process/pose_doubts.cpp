#include "pipeline/process/pose_doubts.h"

#include <algorithm>

#include "core/text.h"
#include "pipeline/occluders.h"
#include "pipeline/scene_loader.h"
#include "pipeline/silhouettes/silhouette_check.h"

namespace floatstage::pipeline {
namespace {

constexpr std::size_t kFewestCameras = 5;

}  // namespace

Result<std::vector<std::string>> pose_doubts(const capture::TakeReader& take, const std::vector<int>& frames,
                                             int threads, Progress* progress) {
  std::vector<std::string> doubts;
  if (take.rig().cameras.size() < kFewestCameras || frames.empty()) return doubts;
  std::vector<int> asked = {frames[frames.size() / 3], frames[2 * frames.size() / 3]};
  asked.erase(std::unique(asked.begin(), asked.end()), asked.end());
  std::vector<InstantMattes> instants;
  const Result<Occluders> occluders = load_occluders(take.layout(), take.rig());
  if (!occluders) return forward(occluders);
  for (const int frame : asked) {
    Result<std::vector<Matte>> mattes = load_mattes(take, frame);
    if (mattes) mattes = occluders->props.silhouettes(take.rig(), std::move(*mattes), threads);
    if (mattes) instants.push_back(*std::move(mattes));  // else the frame itself has failed, and says why
  }
  if (instants.empty()) return doubts;
  const Result<SilhouetteCheck> check =
      check_silhouettes(take.rig(), instants, {.quick = true, .threads = threads, .progress = progress});
  if (!check && check.error().code == ErrorCode::NotFound) return doubts;  // no subject on stage
  if (!check) return forward(check);
  for (std::size_t c = 0; c < check->cameras.size(); ++c)
    if (check->cameras[c].named)
      doubts.push_back(text(sentence(check->cameras[c]), "; `floatstage calibrate silhouettes ",
                            take.layout().folder().string(), " -o RIG` writes a corrected rig"));
  return doubts;
}

}  // namespace floatstage::pipeline
