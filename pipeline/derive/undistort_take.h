#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/frame.h"
#include "core/image.h"
#include "core/result.h"
#include "pipeline/progress.h"

namespace floatstage::pipeline {

struct UndistortOptions {
  std::filesystem::path take, out;
  std::string label;  ///< empty: as it was
  int threads = 0;    ///< 0: one per core
  Progress* progress = nullptr;
};

/// What became of one camera.
struct StraightenedCamera {
  std::string serial;
  bool was_straight = false;  ///< its pictures are as they were
  double kept = 1;            ///< share of its photographs that straight pictures still show
  double hidden = 0;  ///< share of the straight pictures behind bars, since nothing was photographed there
};

struct UndistortReport {
  int frames = 0;
  std::vector<StraightenedCamera> cameras;  ///< in the take's order
  std::vector<std::string> notes;           ///< sentences about what was left out
};

/// Makes `out`, a take of the same instants whose pictures have no lens and no skew: straight() cameras of
/// the same size and focal length at the same places, pictures looked up by Retaking and written without
/// loss; those of cameras that were straight come along as they are. Mattes, clean plates, colours, offsets
/// of times, sound and time code come along, mattes as given ones; hulls and corrections of mattes do not.
/// What nothing was photographed of lies behind bars of added.json, which is written anew: readers hide it
/// and nothing carves there. InvalidArgument when no camera has a lens or skew; AlreadyExists and Io as of
/// UnfinishedFolder; errors of reading name the file; Cancelled. Nothing is left behind when it fails.
/// docs/adr/0280-straight-takes.md
Result<UndistortReport> undistort_take(const UndistortOptions& options);

/// The largest rectangle of pixels that are not 0 in a picture of one channel; of equal ones the first. Empty
/// where all are 0.
PixelBox largest_box(const Image& mask);

}  // namespace floatstage::pipeline
