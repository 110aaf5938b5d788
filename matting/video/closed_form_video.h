#pragma once

#include <memory>

#include "core/image.h"
#include "core/result.h"
#include "matting/closed_form.h"

namespace floatstage::matting {

struct ClosedFormVideoOptions {
  RefineOptions refine;
  int margin = 4;            ///< px of unknown band around the carried matte
  bool still_camera = true;  ///< remember the backdrop wherever it has been seen, and know it again
  double same_backdrop =
      3;               ///< standard deviations of `noise` within which a pixel shows the remembered backdrop
  double noise = 2.5;  ///< 8-bit steps a channel
  double hold_carried = 5e-3;   ///< how hard the carried matte holds unknown pixels …
  double hold_backdrop = 5e-2;  ///< … and that they do not show the remembered backdrop …
  double prior = 1e-3;          ///< … and the guidance

  Result<void> check() const;
};

/// Carries a matte along a clip from frames where it is known: the last matte follows dense flow, its edge
/// becomes an unknown band, and closed form settles the band against the new picture. With a still camera the
/// backdrop that was uncovered so far is remembered, and what shows it again is background, which keeps
/// errors from adding up. One clip; not thread safe; deterministic.
class ClosedFormVideo {
 public:
  static Result<ClosedFormVideo> create(const ClosedFormVideoOptions& options = {});
  ClosedFormVideo(ClosedFormVideo&&) noexcept;
  ClosedFormVideo& operator=(ClosedFormVideo&&) noexcept;
  ~ClosedFormVideo();

  /// Begins, or begins again, from a known matte. The backdrop's memory stays. Errors: InvalidArgument for
  /// sizes that differ or pictures that are not RGB.
  Result<void> keyframe(const Image& picture, const Image& matte);

  /// The matte of the next frame. `guidance` (empty, or one channel): a key's opinion. `keep` (empty, or one
  /// channel): pixels that are 0 or 255 are known. InvalidArgument before the first keyframe and for another
  /// size.
  Result<Image> next(const Image& picture, const Image& guidance = {}, const Image& keep = {});

 private:
  struct Impl;
  explicit ClosedFormVideo(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace floatstage::matting
