#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "calib/rig_formats.h"
#include "capture/take.h"
#include "core/result.h"
#include "pipeline/import/contours.h"
#include "pipeline/import/picture_stream.h"
#include "pipeline/import/video_sync.h"
#include "pipeline/progress.h"
#include "pipeline/world.h"

namespace floatstage::pipeline {

/// What to make of pictures whose size is not the one that their camera was calibrated for.
enum class OtherSize {
  Refuse,   ///< nobody can tell a smaller picture from a part of one
  Scaled,   ///< the whole picture was scaled, each axis by itself
  Cropped,  ///< columns at the right and rows at the bottom were cut off, as codecs do with their padding
};

struct ImportOptions {
  calib::RigFile calibration;  ///< which format, and where
  std::filesystem::path
      pictures;  ///< folder of images, of folders of images, or of videos; empty: beside the calibration
  std::filesystem::path mattes;    ///< the same for mattes that exist already; empty: the alpha channels of
                                   ///< pictures that all have one, else none. They are also the pictures
                                   ///< where `pictures` is empty and none are beside the calibration
  std::filesystem::path contours;  ///< others' contours instead (ContourFiles); empty: none
  ContourOptions contour_options;
  std::filesystem::path plates;      ///< photographs of the empty stage (PlateFiles); empty: none
  std::filesystem::path out;         ///< the new take's folder
  std::vector<std::string> cameras;  ///< serials to take; empty: all
  OtherSize other_size = OtherSize::Refuse;
  FrameRange frames;                 ///< of every video and folder, before they become frame 0, 1, …
  std::optional<double> frame_rate;  ///< frames a second; absent: the videos' own, 25 for folders of images
  capture::TakeCodec codec = capture::TakeCodec::Ffv1;
  /// Videos that were started by hand are brought together by this; absent: their first pictures are one
  /// instant. Then `frame_rate` is that of the take's instants: absent: the slowest video's.
  std::optional<SyncSign> sync;
  std::optional<double> plane;  ///< of a light field: metres before the cameras; absent: where pictures agree
  bool sound = true;            ///< videos' sound tracks are kept (import_sound())
  WorldOptions world;           ///< what the calibration does not say of its world
  std::string label;            ///< empty: the name of the calibration's format
  int threads = 0;              ///< 0: one per core
  Progress* progress = nullptr;  ///< null: unwatched
};

struct ImportReport {
  std::vector<std::string> serials;  ///< the take's cameras, in its order
  int frames = 0;                    ///< instants
  int gaps = 0;                      ///< frames missing because a camera has fewer than the others
  bool mattes = false;
  int plates = 0;                  ///< cameras with photographs of the empty stage
  int sounds = 0;                  ///< sound tracks
  std::vector<CameraSync> sync;    ///< with `sync`: what was measured, one a camera
  std::vector<std::string> notes;  ///< sentences about what was left out or assumed
  std::string world;               ///< a sentence about where the cameras stand, and what was assumed of it
  std::string format;              ///< the calibration's
};

/// Makes a take of others' pictures and calibration. Cameras without pictures and pictures without a camera
/// are left out with a note. A still picture a camera makes a take of one instant. The rig gets the pictures'
/// sizes; a calibration that states another size is BadData unless `other_size` says what happened, and then
/// a note. A light field gets its plane, as give_plane() does. Nothing is left behind when it fails: the take
/// is made under a temporary name beside `out`, which must not exist (or be an empty folder), and renamed.
/// InvalidArgument for mattes and contours both, and for `sync` with either or with a range of frames. All
/// foreign files are read in a confined child (core/confined.h), whose death is an error of run_confined().
Result<ImportReport> import_take(const ImportOptions& options);

}  // namespace floatstage::pipeline
