#pragma once

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/matte/camera_matting.h"
#include "pipeline/matte/matte_doubts.h"
#include "pipeline/matte/matte_store.h"
#include "pipeline/matte/matte_take.h"

namespace floatstage::pipeline {

/// One camera of a run of matte_take().
struct MatteJob {
  int camera = 0;
  double frame_rate = 0;  ///< of the take, frames a second; 0: unknown
  std::string serial, how, guide;
  CameraEdits edits;
  std::vector<bool> wanted;              ///< frames that the run is about
  std::vector<bool> there;               ///< frames that have a matte
  std::vector<bool> ours;                ///< frames whose matte we made
  std::vector<bool> todo;                ///< wanted frames whose matte is to be made
  std::set<int> stale;                   ///< frames of ours that are old and not this run's to make
  bool strokes_only = false;             ///< nothing but strokes is another than what they were made from
  bool settled = false;                  ///< the method that the record says stands
  bool explained = false;                ///< other mattes than before are what was asked for
  bool together = false;                 ///< made by what all cameras say at once: ConsistentMatting
  std::optional<CameraMatting> matting;  ///< absent: nothing to make, or by the cameras together
  CameraMattes report;
  std::map<int, MatteShape> shapes;           ///< of the mattes that were made
  std::vector<CameraMatting::Link> guidance;  ///< without pictures: of those mattes that strokes made others
  std::vector<std::pair<int, std::string>> failures;

  bool nothing_to_do() const;
  /// Whether `auto` still has to find out how.
  bool undecided() const { return how == "auto" && !settled && !nothing_to_do(); }
  /// First and last frame to be made; there is one.
  std::pair<int, int> reach() const;
};

/// Whether somebody else's mattes lie in the take.
Result<bool> anything_given(const capture::TakeReader& take, const MatteStore& store);

/// How mattes are made where nobody says it and the camera has none of ours: as the other cameras', where
/// they agree; "given" where somebody put mattes into the take; else "auto".
Result<std::string> usual_way(const capture::TakeReader& take, const MatteStore& store);

/// The cameras that the options ask for, and of each how its mattes are made and which of them are to be
/// made: those that are missing, stale, or ours and made from other edits or inputs; with `redo` all of ours.
/// Errors: InvalidArgument for what there is not; AlreadyExists when ours were made otherwise, without
/// `redo`.
Result<std::vector<MatteJob>> matte_jobs(const capture::TakeReader& take, const MatteStore& store,
                                         const MatteEdits& edits, const MatteTakeOptions& options);

/// Makes the key of a job that has something to do and writes it into `record`, the camera's part of the
/// store's record. More may be to do then: all of ours, when the key is another one.
Result<void> prepare(capture::TakeReader& take, const MatteTakeOptions& options, CameraRecord& record,
                     MatteJob& job);

/// Settles the method of a job that has been prepared, where the record has none.
Result<void> choose_method(CameraRecord& record, MatteJob& job);

/// From now on the job's camera is made together with all others.
void make_together(CameraRecord& record, MatteJob& job);

/// What the record says from now on: this job's way and edits, and of ours what is still to be made.
void begin(const MatteJob& job, CameraRecord& record);

/// SHA-256 of what a camera's mattes are made from, but for the edits: which photographs there are, plates,
/// the guide, what a person gave.
Result<std::string> hash_of_inputs(const capture::TakeReader& take, const std::string& serial,
                                   const std::string& guide);

}  // namespace floatstage::pipeline
