#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/rig.h"
#include "pipeline/silhouettes/left_out_hulls.h"

namespace floatstage::pipeline {

/// How a camera's pictures lie in those of the camera that the rig has in its place.
enum class PictureFlip { None, UpsideDown, Mirrored, MirroredUpsideDown };

/// "as taken", "upside down", "mirrored", "mirrored top to bottom".
const char* name_of(PictureFlip flip);

/// A camera whose pictures are not those of the camera that the rig says it is.
struct MisplacedCamera {
  std::size_t camera = 0;
  std::size_t place = 0;                 ///< where it stands: another camera's, or its own
  PictureFlip flip = PictureFlip::None;  ///< never with another's place
  double iou = 0;                        ///< of its mattes with what the others leave, as the rig says
  double iou_there = 0;                  ///< likewise, at that place or with pictures turned so
};

/// Whether pictures were taken for those of another camera, are upside down or mirrored, from mattes of some
/// instants. Suspected are those that agree least with a hull that all cameras but two agree on or, where
/// that tells nothing, all but a quarter. Each is held against the hull of all cameras that are not
/// suspected, at the places of all suspects and flipped, and once more against that of all but those who fit
/// better elsewhere: places are exchanged in circles. What that suggests is true if the hull of all cameras,
/// with these mattes where they belong, leaves half as much of the silhouettes unexplained. Nothing for fewer
/// than five cameras, or where the hull explains most as it is. In the order of the rig; the result is the
/// same at any number of threads.
std::vector<MisplacedCamera> misplaced_cameras(const Rig& rig, const std::vector<InstantMattes>& instants,
                                               int threads);

/// The rig in which they stand where they are; absent where mirrored pictures are among them, which no camera
/// makes.
std::optional<Rig> with_cameras_in_place(const Rig& rig, const std::vector<MisplacedCamera>& misplaced);

/// "camera 'x' shows what camera 'y' should see: …"
std::string sentence(const Rig& rig, const MisplacedCamera& misplaced);

}  // namespace floatstage::pipeline
