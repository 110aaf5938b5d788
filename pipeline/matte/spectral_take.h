#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "matting/video/video_matting.h"
#include "pipeline/matte/camera_matting.h"

namespace floatstage::pipeline {

/// One camera's mattes by spectral video matting: the key is the likelihood; a keyframe is the matte that the
/// key, or without one its first stroke on the subject, chooses in that frame by itself, guided by its
/// strokes (guided_matte()); masks outrank all. `cache` keeps the components, so that a second run only
/// propagates. What was propagated is kept too: after other edits only what lies between the keyframes
/// concerned is made again. `take` outlives it. Calls come from one thread.
class SpectralTake {
 public:
  /// With `threads` workers of about 0.4 GB each. Errors: those of VideoMatting::create().
  static Result<SpectralTake> create(capture::TakeReader& take, int camera, const CameraKey& key,
                                     const std::filesystem::path& cache, int threads);

  /// Components of all frames; `done` as in VideoMatting::prepare().
  Result<void> prepare(const std::function<bool(int frame)>& done) { return video_.prepare(done); }
  /// What is said now, after prepare(); another call replaces it. Errors: those of
  /// VideoMatting::matte_alone() and guided_matte().
  Result<void> say(const CameraMatting& matting);
  /// Makes the mattes from `first` to `last` that are stale.
  Result<void> propagate(const std::function<bool(int frame)>& done, int first, int last);
  /// In the photograph's size, masks written over it; empty for a gap.
  Result<Image> matte(const CameraMatting& matting, int frame) const;

  /// Sentences on strokes that change nothing, of what is said now.
  std::vector<std::string> idle() const;
  /// For each frame, whether what is said now reaches it: all where a keyframe says something, since
  /// components and flow carry its matte both ways; else those alone whose strokes act in their own frame.
  std::vector<bool> reached(int frames) const;
  int usable() const { return video_.usable(); }
  Result<matting::MattingComponents> components(int frame) const { return video_.components(frame); }

 private:
  SpectralTake(capture::TakeReader& take, int camera, matting::VideoMatting video)
      : take_(&take), camera_(camera), video_(std::move(video)) {}

  capture::TakeReader* take_;
  int camera_;
  matting::VideoMatting video_;
  Result<void> say(const CameraMatting& matting, const MatteKeyframe& keyframe);

  struct Said {
    MatteKeyframe keyframe;
    CameraMatting::Link made;
    bool carried = false;  // it is a keyframe of the video's
  };
  std::map<int, Said> said_;  // keyframes with strokes
};

/// Where the matting components of a camera are kept.
inline std::filesystem::path spectral_cache(const TakeLayout& layout, const std::string& serial) {
  return layout.mattes() / "spectral" / serial;
}

/// The components of one frame alone, where SpectralTake has not prepared it.
Result<matting::MattingComponents> components_of_frame(capture::TakeReader& take, int camera, int frame,
                                                       const std::filesystem::path& cache);

}  // namespace floatstage::pipeline
