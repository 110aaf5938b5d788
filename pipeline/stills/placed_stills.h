#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/image.h"
#include "core/result.h"
#include "pipeline/export/instant.h"
#include "pipeline/progress.h"

namespace floatstage::pipeline {

/// Where a close still shows a part of a camera's photograph.
struct StillPlace {
  std::size_t still = 0, camera = 0;  ///< of PlacedStills::stills, of StraightInstant::rig
  /// Pixels of the still to those of the photograph, corners at whole numbers.
  Eigen::Matrix3d photo_from_still = Eigen::Matrix3d::Identity();
  double zoom = 1;  ///< linear: pixels of the still in one of the photograph
};

struct Still {
  std::string name;  ///< below the folder of stills
  Image picture;     ///< RGB, as it is to be seen
};

/// A still that no camera's photograph has a place for, and why: an end of a sentence.
struct RefusedStill {
  std::string name, why;
};

struct PlacedStills {
  std::vector<Still> stills;          ///< those with a place, by name
  std::vector<StillPlace> places;     ///< by still, then by camera
  std::vector<RefusedStill> refused;  ///< by name
};

struct PlaceStillsOptions {
  std::filesystem::path folder;   ///< of the stills, with the folders in it
  std::filesystem::path scratch;  ///< an empty folder to work in; what is left in it may be removed
  int threads = 0;                ///< 0: one per core
  Progress* progress = nullptr;
};

/// Finds which stills show a part of which photograph of an instant (detail::relate_photos(),
/// detail::choose_parents(): thesis 4.2), also by way of another still. The photographs' backdrops are not
/// looked at: a still that was taken from beside a camera shows another part of them. Stills are decoded and
/// related in a confined child (docs/adr/0268). Errors: NotFound when there is no such folder; BadData when
/// no still can be read; Cancelled; Io.
Result<PlacedStills> place_stills(const StraightInstant& instant, const PlaceStillsOptions& options);

}  // namespace floatstage::pipeline
