#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "capture/sound/sound_record.h"
#include "capture/take.h"
#include "core/image.h"

namespace floatstage::pipeline {

/// What a take holds, at a glance.
struct TakeFacts {
  int frames = 0, cameras = 0;
  double seconds = 0;       ///< from the first exposure to the last
  std::uint64_t bytes = 0;  ///< of media and side files
  int mattes = 0, meshes = 0;
};
TakeFacts facts_of(const capture::TakeReader& take);

/// Its first exposure; nothing without rows.
std::optional<Timestamp> begin_of(const capture::TakeReader& take);

/// A sound track of a take.
struct SoundFacts {
  capture::SoundTrack track;
  double seconds = 0;
  double begins = 0;  ///< seconds after the first picture
  double ppm = 0;     ///< how much faster its clock ran than it says
  double jitter_ms = 0;
  int runs = 0;         ///< without a gap
  std::string problem;  ///< why it does not open, or what it lacks
};
/// BadData, Io: of sound.json.
Result<std::vector<SoundFacts>> sounds_of(const capture::TakeReader& take);

struct ListedTake {
  std::string name;  ///< of its folder
  /// What there is to say, the worst first: "does not open: …", "FAIL: …" of its recorder, "cut off", "not
  /// sealed"; else "PASS" where a recorder said so, or "whole".
  std::string verdict;
  bool opens = false;
  TakeManifest manifest;  ///< empty unless it opens
  TakeFacts facts;
};

/// The takes in a folder, by name; the folder itself where it is one. What is no take is left out. Nothing is
/// decoded. NotFound, Io.
Result<std::vector<ListedTake>> list_takes(const std::filesystem::path& folder);

/// The middle instant as its first camera with a picture saw it, `width` pixels wide at most. NotFound where
/// there is no picture.
Result<Image> thumbnail(capture::TakeReader& take, int width);

}  // namespace floatstage::pipeline
