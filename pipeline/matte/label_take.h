#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "capture/take.h"
#include "core/result.h"
#include "pipeline/label_record.h"
#include "pipeline/matte/label_givens.h"
#include "pipeline/matte/matte_take.h"
#include "pipeline/progress.h"

namespace floatstage::pipeline {

/// What somebody says of a take's labels by masks and clicks: all of it, it replaces what was said before in
/// this way. Strokes of mattes/edits.json that have a subject say the same, and stay until they are removed
/// there.
struct LabelsSaid {
  std::vector<LabelMasks> masks;   ///< at most one folder a label
  std::vector<LabelClick> clicks;  ///< of those labels and of others
};

struct LabelTakeOptions {
  std::optional<LabelsSaid> said = {};  ///< absent: what was said before
  int threads = 0;                      ///< 0: one per core
  bool redo = false;                    ///< make again what we made
  Progress* progress = nullptr;         ///< null: unwatched
};

struct LabelTakeReport {
  std::vector<std::string> labels;  ///< empty: nobody asked for any
  int given = 0;                    ///< photographs of which something was said
  int made = 0, kept = 0;           ///< label mattes
  int others = 0;                   ///< of unknown origin, among those that were kept
  std::vector<MatteDoubt> doubts;   ///< made now or before
  double seconds = 0;
};

/// Divides a take's mattes among labels: mattes/<serial>/<label>/<frame>.png beside the sum, of every camera
/// and frame that has one, which add up to it exactly. One mask, click or stroke a label is enough; it is
/// carried in time and to other cameras by what they see together (label_follower.h). Kept where nothing has
/// changed: sums, masks, clicks, strokes, rig; else all are made again. When the last stroke that named a
/// label is gone, and nothing else does, what we made goes, too. Label mattes of unknown origin are never
/// touched; they are masks. What was said is kept in the take. Files take their places when all are made.
///
/// Errors: InvalidArgument for names that are no labels, fewer than two or more than 31 of them, and what
/// label_givens() says; NotFound for a take without mattes; BadData, also for a damaged edits.json; Io;
/// Cancelled, as if it had not been called.
Result<LabelTakeReport> label_take(capture::TakeReader& take, const LabelTakeOptions& options);
/// Likewise; the take is opened and claimed.
Result<LabelTakeReport> label_take(const std::filesystem::path& take, const LabelTakeOptions& options);

}  // namespace floatstage::pipeline
