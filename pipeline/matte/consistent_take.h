#pragma once

#include <string>
#include <vector>

#include "capture/take.h"
#include "core/matte_edits.h"
#include "core/result.h"
#include "pipeline/matte/consistent.h"
#include "pipeline/matte/matte_store.h"
#include "pipeline/progress.h"

namespace floatstage::pipeline {

struct ConsistentTakeOptions {
  ConsistentOptions matting;
  struct Camera {
    int index = 0;           ///< in the rig
    std::vector<bool> todo;  ///< frames whose matte is written, whatever lies there
  };
  std::vector<Camera> cameras = {};  ///< whose mattes are written; all are looked at in any case
  Progress* progress = nullptr;      ///< null: unwatched
};

struct ConsistentTakeReport {
  struct Camera {
    int made = 0, gaps = 0;
    /// Means over the instants that were made: see ConsistentView.
    ConsistentView mean;
  };
  std::vector<Camera> cameras;       ///< as in the options
  std::vector<std::string> remarks;  ///< "frame 3: cameras 04 (62 %): …"; no more than some dozens
  int distrusted = 0;                ///< instants whose mattes are probably wrong
};

/// Makes mattes of a take by ConsistentMatting and puts them into `store`, instant after instant, each
/// beginning where the last one ended; one that cannot be trusted is tried again as if it were the first. A
/// run that goes on after an interruption, or that makes some instants only, begins anew at the first of
/// them, so that its mattes may differ there by a few pixels. Where the take has eight instants or more, each
/// camera's backdrop is learnt from up to sixteen of them. Strokes and masks of `edits` are certain, strokes
/// in their own frame only. Errors: those of ConsistentMatting and of reading and writing; Cancelled.
Result<ConsistentTakeReport> consistent_take(capture::TakeReader& take, const MatteEdits& edits,
                                             const ConsistentTakeOptions& options, MatteStore& store);

/// The mattes of one instant, as consistent_take() makes them where it is the first that is asked for. Writes
/// nothing. Errors likewise.
Result<ConsistentMattes> consistent_instant(capture::TakeReader& take, int frame, int threads,
                                            Progress* progress);

}  // namespace floatstage::pipeline
