#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "apps/calibrate/session.h"
#include "calib/observations.h"
#include "core/result.h"

namespace floatstage {

/// What a session's pictures show.
struct Collected {
  Observations observations;
  std::vector<std::string> detection;  ///< a sentence a camera
  std::vector<std::string> remarks;
  double seconds = 0;
};

/// Finds the target in all pictures of a session and adds what is known beforehand. Errors name the camera and the file: a
/// folder without pictures, a picture that is cut off, cameras with unequal numbers of pictures.
Result<Collected> collect(const Session& session, const std::filesystem::path& cache, int threads);

/// The known rig of a session, in whatever format it is.
Result<Rig> load_known(const SessionKnown& known);

/// Fills in what the session knows of its cameras. NotFound names the camera that the known rig lacks.
Result<void> apply_known(const SessionKnown& known, const Rig& rig, Observations& observations);

/// How far the solved focal lengths are from the known ones, where those were only to be compared.
std::vector<std::string> compare_to_known(const SessionKnown& known, const Rig& rig, const Rig& solved);

}  // namespace floatstage
