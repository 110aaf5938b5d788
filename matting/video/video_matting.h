#pragma once

#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <vector>

#include "core/image.h"
#include "core/result.h"
#include "matting/spectral/spectral_matting.h"

// Spectral video matting: thesis section 7.3.
namespace floatstage::matting {

/// One camera's frames, fetched when they are needed.
struct MattingClip {
  int frames = 0;
  /// The photograph of a frame, 1 or 3 channels, all of one size. Called from several threads at a time.
  std::function<Result<Image>(int frame)> photograph;
  /// What a keyer or a clean plate says about a frame, in any size; an empty opinion is none. May be absent.
  /// Called from one thread.
  std::function<Result<MatteConstraint>(int frame)> likelihood = nullptr;
};

struct VideoMattingOptions {
  SpectralOptions spectral = {};
  int working_pixels =
      86400;  ///< photographs are scaled to about so many (360x240) for everything but the way back up
  double guidance_strength = 1;    ///< of the carried matte, eq. 7.5
  double likelihood_strength = 1;  ///< of MattingClip::likelihood
  bool likelihood_is_matte =
      false;  ///< the likelihood is a whole matte, and is it where no components come near it
  double keyframe_strength = 4;  ///< of what was said in a keyframe; a click counts as much as a whole matte
  double persistence = 0.02;     ///< of each component's last choice
  double misfit = 0.05;  ///< relative squared difference to the guidance from which components do not fit
  double temporal_filter =
      0.3;          ///< share of the previous matte, carried by flow where it fits; 0 … 0.9, 0: none
  int threads = 0;  ///< for prepare(): 0 is one a core; each holds about 0.4 GB

  Result<void> check() const;
};

/// How a frame's matte came about.
struct MattedFrame {
  double energy = 0;   ///< of the selection; the largest ones want a keyframe
  double flicker = 0;  ///< mean |matte - previous matte carried by flow|, 0..1; 0 for the first frame
  bool keyframe = false;
  bool fits = true;  ///< false: no subset of components is near the guidance, and closed form carried the
                     ///< matte instead
};

/// Mattes for a clip from a few keyframes. Three phases: prepare() computes every frame's matting components
/// and keeps them on disk; keyframes say what is subject; propagate() carries the matte by flow as guidance
/// G_j (eq. 7.4) and chooses components anew in every frame (eq. 7.5), forwards and backwards from keyframes
/// and blended between two, then filters along the flow. Where no subset of components comes near the
/// guidance (clutter: a known limit of spectral matting), closed form carries the matte on in that frame. A
/// keyframe that gives a whole matte has that matte. Memory: 0.4 GB a thread in prepare(), 0.2 MB a frame
/// afterwards. Deterministic at any thread count. Calls on one object come from one thread.
class VideoMatting {
 public:
  /// `cache` is a folder of this clip's own; it is made. Errors: what check() finds; what the first
  /// photograph's callback returns; InvalidArgument for a clip without frames; Io.
  static Result<VideoMatting> create(MattingClip clip, const std::filesystem::path& cache,
                                     const VideoMattingOptions& options = {});
  VideoMatting(VideoMatting&&) noexcept;
  VideoMatting& operator=(VideoMatting&&) noexcept;
  ~VideoMatting();

  int frames() const;  ///< of the clip
  int width() const;   ///< of photographs and full-size mattes, px
  int height() const;
  int working_width() const;  ///< of components
  int working_height() const;

  /// Computes the components that the cache does not hold for these photographs and options; files that are
  /// cut off or stale are computed again. `done(frame)` is called after each frame, from several threads, and
  /// may stop the work by returning false (Cancelled; what is finished is kept). On an error frames up to the
  /// first bad one stay usable: usable() says how many. Errors name the frame: what the photograph's callback
  /// or matting_components() returns; BadData when a photograph has another size than the first or one colour
  /// only; Io when the disk is full.
  Result<void> prepare(const std::function<bool(int frame)>& done = nullptr);

  /// Frames from the first that have components.
  int usable() const;

  /// The components of a frame below usable(), from the cache. Component k is the same part of the picture as
  /// in the frame before, within a dozen frames. Io, BadData naming the file.
  Result<MattingComponents> components(int frame) const;

  /// Says what is subject in a frame: a whole matte (weight empty) or strokes, of any size. Replaces what was
  /// said there. Only frames between the neighbouring keyframes become stale. InvalidArgument for a frame
  /// that is not there and for an opinion that is all subject or all background where it covers the frame.
  Result<void> set_keyframe(int frame, const MatteConstraint& opinion);
  void remove_keyframe(int frame);

  /// The matte of a frame below usable(), of the photograph's size, from its own components, its likelihood
  /// and `opinion` (may be empty, of any size) alone, whatever the keyframes; by guess_selection() without
  /// either. Sets nothing. Errors: those of components() and the clip's callbacks; InvalidArgument as above.
  Result<Image> matte_alone(int frame, const MatteConstraint& opinion) const;

  /// Makes the stale mattes and returns their frames in order. Without keyframes and likelihood the first
  /// frame starts from guess_selection(). Errors: InvalidArgument when the first keyframe marks no subject
  /// and nothing else does; those of components() and the clip's callbacks. Frames made before an error stay.
  /// Only spans between keyframes that reach into frames `first` to `last` are made. `done(frame)` is called
  /// on the way, for some frames several times, and stops the work by returning false (Cancelled; spans that
  /// were finished stay).
  Result<std::vector<int>> propagate(const std::function<bool(int frame)>& done = nullptr, int first = 0,
                                     int last = std::numeric_limits<int>::max());

  /// A frame's matte in working size, or carried up to the photograph's size by the local affine colour
  /// model. Both NotFound when propagate() has not made it yet.
  Result<Image> working_matte(int frame) const;
  Result<Image> matte(int frame) const;

  const MattedFrame& report(int frame) const;

 private:
  struct Impl;
  explicit VideoMatting(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// How much a matte jumps where the picture does not: mean |matte - previous matte carried along by flow|,
/// 0..1, at about 200x150. The photographs have 1 or 3 channels, the mattes one; all are of one size
/// (InvalidArgument else).
Result<double> matte_flicker(const Image& photograph_before, const Image& matte_before,
                             const Image& photograph, const Image& matte);

}  // namespace floatstage::matting
