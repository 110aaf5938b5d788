#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/matte_edits.h"
#include "core/result.h"
#include "core/take_layout.h"

namespace floatstage::pipeline {

/// A matte that the others contradicted and that was made again by their evidence.
struct Healing {
  double lost = 0, gained = 0;  ///< before, see recon::SilhouetteVerdict; lost 1: there was none
  std::vector<std::string> by;  ///< cameras whose mattes were believed
  bool operator==(const Healing&) const = default;
};

/// How one camera's mattes were made, and which files that are.
struct CameraRecord {
  std::string how;     ///< as asked for: one of matte_methods(), perhaps with a parameter
  std::string method;  ///< what came of it: key, closed-form, spectral, consistent; empty: not settled
  std::string key;     ///< what first told the subject: "chroma:#2f7a45", "plate:6", "cut", "guide", "none"
  std::string guide;   ///< the folder of others' mattes to start from, or nothing
  std::string inputs;  ///< SHA-256 of what they were made from, but for the edits
  CameraEdits edits;   ///< that they were made with, without_subjects()
  std::map<int, std::string> files;    ///< SHA-256 of every matte that was made, by frame
  std::set<int> stale;                 ///< frames whose mattes are to be made again
  std::map<int, Healing> healed = {};  ///< of those files, by frame
  /// Frames whose mattes were compared with those of all cameras, changed by that or not, and the hash of the
  /// instant's mattes afterwards (hash_of_instant()): they are compared again only when one is another.
  std::map<int, std::string> compared = {};
  std::set<int> guided = {};  ///< frames whose files strokes, their own or carried ones, made others
  /// Why mattes of those files are not to be trusted, a sentence, and which frames'.
  std::map<std::string, std::set<int>> doubts = {};

  /// What was said of a frame's matte that is not there any more.
  void forget(int frame);
  bool operator==(const CameraRecord&) const = default;
};

/// mattes/made.json, by serial. A matte that it does not know, or knows with other bytes, is of unknown
/// origin: somebody put it there.
using MatteRecord = std::map<std::string, CameraRecord>;

/// With what the journal holds beside it. Empty without a file. BadData names the file.
Result<MatteRecord> load_matte_record(const TakeLayout& layout);
/// Whole or not at all.
Result<void> save_matte_record(const MatteRecord& record, const TakeLayout& layout);

}  // namespace floatstage::pipeline
