#pragma once

#include <vector>

#include "core/image.h"
#include "core/matte_edits.h"
#include "core/result.h"

namespace floatstage::matting {

/// What became of one stroke.
enum class StrokeEffect {
  Acted,    ///< pixels of the matte are others because of it
  Already,  ///< everything that it marks was so
  Outside,  ///< it marks no pixel of the picture
};

/// What the neighbouring frame's matte owes to a person, brought to this frame.
struct CarriedGuidance {
  Image said;    ///< 1 channel: 255 and 0 where it is said, 128 elsewhere; empty: nothing was
  Image within;  ///< 255 where it may act
  /// Where the neighbour's change lies now, or, where flow does not find it again, lay: 255 and 0 as somebody
  /// said there, 128 elsewhere.
  Image followed;
};

/// Follows along dense flow what a person has changed in the neighbour's matte: `matte` is what became of
/// `base`. Of the core of each change is said in the new frame what was said there, as far as flow finds it
/// again and this frame's own `base` has the same fault. All pictures have one size, 16x16 at least.
CarriedGuidance carried_guidance(const Image& neighbour, const Image& neighbours_base,
                                 const Image& neighbours_matte, const Image& picture, const Image& base);

/// What a person changed in the neighbouring frame and what is not so in this one, though the same fault is
/// there.
struct EndedChange {
  MatteLabel said;
  Eigen::Vector2d at;  ///< a pixel of it in this frame, in its middle
  double area;         ///< px
};

/// The pieces of what was carried of whose faulty pixels in `base` three tenths, and more than a hundredth of
/// the subject, are faulty in `matte` as well. Where `said` (as paint_strokes(): 0, 128 or 255, of this
/// frame) says otherwise, a change has not ended but been taken back. Largest first.
std::vector<EndedChange> ended_changes(const CarriedGuidance& carried, const Image& base, const Image& matte,
                                       const Image& said);

struct GuidedMatte {
  Image matte;
  std::vector<StrokeEffect> effects;  ///< one a stroke
};

/// A matte that follows what a person says in its own frame, stroke after stroke, so that a stroke more never
/// takes back what the ones before have done.
///
/// What a stroke marks is as it says, exactly. If part of it was on the wrong side, what hangs together with
/// that by colour and contour turns over with it (stroke_region.h): missing parts come, and things that are
/// not the subject go. Nothing else changes. Where an outline is new, closed form solves its edge.
///
/// `picture`: RGB, at least 3x3. `matte`: one channel of its size. `fixed`: empty, or of its size: what is
/// not 128 there is certain and stays (garbage and hold-out masks). `carried` is heard before the strokes,
/// and any of them may overrule it. Deterministic, one thread; about 0.1 s a stroke at 1280x720. Errors:
/// those of closed_form_matte(); InvalidArgument for sizes that do not fit.
Result<GuidedMatte> guided_matte(const Image& picture, const Image& matte,
                                 const std::vector<MatteStroke>& strokes, const Image& fixed = {},
                                 const CarriedGuidance& carried = {});

}  // namespace floatstage::matting
