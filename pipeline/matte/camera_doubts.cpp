#include "pipeline/matte/camera_doubts.h"

#include "core/text.h"
#include "pipeline/matte/time_doubts.h"
#include "pipeline/silhouettes/asked_instants.h"
#include "pipeline/silhouettes/misplaced_cameras.h"

namespace floatstage::pipeline {

Result<std::vector<std::string>> camera_doubts(const capture::TakeReader& take,
                                               const std::vector<int>& frames, int threads,
                                               Progress* progress) {
  const Result<AskedInstants> instants = asked_instants(take, frames, threads);
  if (!instants) return forward(instants);
  const std::vector<MisplacedCamera> misplaced = misplaced_cameras(take.rig(), instants->mattes, threads);
  if (misplaced.empty()) return time_doubts(take, frames, threads, progress);
  const bool mends = with_cameras_in_place(take.rig(), misplaced).has_value();
  const std::string name = take.layout().folder().string();
  std::vector<std::string> doubts;
  for (const MisplacedCamera& one : misplaced)
    doubts.push_back(
        text(sentence(take.rig(), one),
             mends ? text("; `floatstage calibrate silhouettes ", name,
                          " -o RIG` writes the rig in which it stands there, `floatstage take set-rig ", name,
                          " RIG -o NEW` makes the take with it")
                   : std::string("; import its pictures mirrored back")));
  return doubts;
}

}  // namespace floatstage::pipeline
