#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/result.h"
#include "pipeline/progress.h"
#include "pipeline/stills/placed_stills.h"

namespace floatstage::pipeline {

struct DetailedTakeOptions {
  std::filesystem::path take, out;
  std::filesystem::path stills;  ///< a folder of close photographs of the instant
  int frame = 0;                 ///< the instant, of `take`
  /// How many times photographs with details are enlarged, 1 to 16; 0: as the closest still, at most 4, and
  /// as far as 32 million pixels allow.
  int zoom = 0;
  bool paint_provenance = false;  ///< pictures are painted by where their pixels come from
  std::string label = {};         ///< empty: as it was
  int threads = 0;                ///< 0: one per core
  Progress* progress = nullptr;
};

/// What a still gave to a camera's photograph.
struct StillInPhoto {
  std::string still;
  bool direct = true;   ///< found in this photograph; false: carried over from another by way of the hull
  double zoom = 1;      ///< its pixels in one of the photograph, linear
  double used = 0;      ///< share of the photograph's subject
  double moved = 0;     ///< px of the photograph, mean
  std::string why_not;  ///< why nothing of it is used; empty: some is
};

struct DetailedCamera {
  std::string serial;
  int zoom = 1;                      ///< its pictures are so many times larger than they were
  std::vector<StillInPhoto> stills;  ///< by name
};

struct DetailedTakeReport {
  std::vector<DetailedCamera> cameras;
  std::vector<RefusedStill> refused;
  std::vector<std::string> notes;  ///< sentences about what was left out
};

/// Makes `out`, a take of one instant of a processed take, whose photographs have the details that close
/// stills of the performer show: face, hands, a print. Stills are found in the photographs (place_stills()),
/// bent to them by optical flow, and give them what they show finer (EnlargedPhoto); from there what they
/// show goes by way of the hull to the other cameras that see the same surface. Cameras whose photographs got
/// something are larger by one factor; all are straight (straight()), their colours are those of `calibrate
/// color`. Mattes and hull come along; every verb that reads takes shows the details. detail/<serial>.png
/// says where each pixel comes from.
///
/// Errors: those of load_straight_instant() and place_stills(); NotFound when no still has a place, with the
/// reasons; AlreadyExists and Io as of UnfinishedFolder; Cancelled. Nothing is left behind when it fails.
/// docs/adr/0297-stills-give-details-to-photographs.md
Result<DetailedTakeReport> add_detail(const DetailedTakeOptions& options);

}  // namespace floatstage::pipeline
