#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "calib/observations.h"
#include "calib/scene_features.h"
#include "core/result.h"
#include "pipeline/calibrate/session.h"
#include "pipeline/progress.h"

namespace floatstage::pipeline {

/// What a session's pictures show.
struct SessionObservations {
  calib::Observations observations;
  std::vector<std::string> detection;  ///< a sentence a camera
  std::vector<std::string> remarks;
  std::vector<std::string>
      carried;  ///< serials of pictures that a carried camera took: solved for, but not of the rig
  double seconds = 0;
};

/// Finds the target in all pictures of a session and adds what is known beforehand. Errors name the camera
/// and the file: a folder without pictures, a picture that is cut off, cameras with unequal numbers of
/// pictures.
Result<SessionObservations> collect(const Session& session, const std::filesystem::path& cache, int threads,
                                    Progress* watch = nullptr);

/// Files as they are, folders as the pictures in them, in natural order. NotFound names the camera of an
/// empty folder.
Result<std::vector<std::filesystem::path>> pictures_of(const std::vector<std::filesystem::path>& given,
                                                       const std::string& serial);

/// The known rig of a session, in whatever format it is.
Result<Rig> load_known(const SessionKnown& known);

/// Fills in what the session knows of its cameras. NotFound names the camera that the known rig lacks.
Result<void> apply_known(const SessionKnown& known, const Rig& rig, calib::Observations& observations);

/// How far the solved poses are from the known ones after a similarity; absent where those were not only to
/// be compared. Errors of calib::agreement() say why there is nothing to compare.
std::optional<Result<calib::RigAgreement>> compare_poses(const SessionKnown& known, const Rig& rig,
                                                         const Rig& solved);

/// How far the solved focal lengths are from the known ones, where those were only to be compared.
std::vector<std::string> compare_to_known(const SessionKnown& known, const Rig& rig, const Rig& solved);

}  // namespace floatstage::pipeline
