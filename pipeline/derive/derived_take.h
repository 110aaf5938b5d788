#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "capture/sound/sound_record.h"
#include "capture/sound/time_code.h"
#include "capture/take.h"
#include "capture/time_offsets.h"
#include "core/rig.h"

namespace floatstage::pipeline {

/// A sound track whose files lie in a folder, which keeps them.
struct AddedSound {
  std::filesystem::path folder;
  capture::SoundTrack track;  ///< of a name that the take does not have
};

/// What is other in a take that is made from another one.
struct DerivedTake {
  std::optional<Rig> rig;   ///< the same cameras in the same order; absent: the same rig
  int first = 0, end = -1;  ///< instants; -1: to the last
  std::string how;          ///< for derived.json
  std::string label;        ///< empty: as it was
  std::optional<capture::TimeCode> time_code = {};  ///< absent: as it was
  std::optional<AddedSound> sound = {};             ///< becomes the first track: what is heard
  /// By camera, by how many frames its pictures are moved to later instants; empty: none is. Its stamps are
  /// moved along by the take's frame rate, and mattes that we made are left out.
  std::vector<int> moved = {};
  std::optional<capture::TimeOffsetFile> times = {};  ///< absent: as they were
};

struct DerivedReport {
  int frames = 0;
  std::uint64_t shared = 0, copied = 0;  ///< bytes of media
  std::vector<std::string> notes;        ///< sentences about what was left out
};

/// Makes `out`, a take with the media of `from`: the same files under a second name (hard links), or copies
/// where the file system cannot, so that nothing is decoded and either may be removed. Mattes, plates and
/// colours come along; hulls do not, unless rig and instants are the same. A seal stays whole. AlreadyExists
/// and Io as of UnfinishedFolder; InvalidArgument for instants that are not there, also of a camera whose
/// pictures are moved, or another rig than `from`'s cameras. Nothing is left behind when it fails.
Result<DerivedReport> derive_take(const capture::TakeReader& from, const DerivedTake& other,
                                  const std::filesystem::path& out);

/// The rig of `known` for the cameras of `take`: by serial (with or without a picture's extension), in the
/// take's order. A size that `known` does not state is the take's; another one is BadData. NotFound names the
/// cameras that it does not have.
Result<Rig> rig_for(const capture::TakeReader& take, const Rig& known, const std::string& name_for_errors);

}  // namespace floatstage::pipeline
