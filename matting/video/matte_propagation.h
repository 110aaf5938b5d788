#pragma once

#include <optional>
#include <vector>

#include "matting/video/frame_flow.h"
#include "matting/video/video_matting.h"

// Private to the stage: how one frame's matte follows from its neighbours'.
namespace floatstage::matting {

/// What is known of a frame before its components are chosen, all in working size.
struct FrameEvidence {
  MatteConstraint keyframe;    ///< empty: none
  MatteConstraint likelihood;  ///< empty: none
  struct Carried {
    MatteConstraint guidance;       ///< G_j and where it can be trusted
    std::vector<bool> last_choice;  ///< empty across runs, where component k is another
    double share = 1;               ///< of two directions
  };
  std::vector<Carried> carried;
};

/// The guidance that a matte gives to a neighbouring frame (eq. 7.4).
MatteConstraint guidance_from(const Image& matte, const Image& its_picture, const Image& picture);

/// Chooses components by all the evidence (eq. 7.5). InvalidArgument when there is none.
Result<Selection> choose(const MattingComponents& components, const FrameEvidence& evidence,
                         const VideoMattingOptions& options);

/// How far a matte is from the guidance where that can be trusted: sum w (G - M)^2 / sum w G^2. 0 for no
/// guidance.
double misfit_of(const Image& matte, const std::vector<FrameEvidence::Carried>& carried);

/// Blends `matte` with the carried previous one where that explains the picture and differs little: noise and
/// shimmer, not motion.
Image filtered(const Image& matte, const MatteConstraint& previous, double share);

/// Mean |matte - carried previous| over the pixels, 0..1.
double flicker_between(const Image& matte, const Image& carried_previous);

}  // namespace floatstage::matting
