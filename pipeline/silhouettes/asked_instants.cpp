#include "pipeline/silhouettes/asked_instants.h"

#include <algorithm>

#include "pipeline/occluders.h"
#include "pipeline/scene_loader.h"

namespace floatstage::pipeline {

Result<AskedInstants> asked_instants(const capture::TakeReader& take, const std::vector<int>& frames,
                                     int threads) {
  AskedInstants instants;
  if (frames.empty()) return instants;
  std::vector<int> asked = {frames[frames.size() / 3], frames[2 * frames.size() / 3]};
  asked.erase(std::unique(asked.begin(), asked.end()), asked.end());
  const Result<Occluders> occluders = load_occluders(take.layout(), take.rig());
  if (!occluders) return forward(occluders);
  for (const int frame : asked) {
    Result<std::vector<Matte>> mattes = load_mattes(take, frame);
    if (mattes) mattes = occluders->props.silhouettes(take.rig(), std::move(*mattes), threads);
    if (!mattes) continue;
    instants.frames.push_back(frame);
    instants.mattes.push_back(*std::move(mattes));
  }
  return instants;
}

}  // namespace floatstage::pipeline
