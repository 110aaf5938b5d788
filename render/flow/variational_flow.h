#pragma once

#include <memory>

#include "render/flow.h"

namespace floatstage::render {

/// Dense optical flow by minimising an energy (thesis 2.10; Brox, Bruhn, Papenberg and Weickert 2004):
/// constancy of brightness and of its gradient, each under a Charbonnier penalty of its own and normalised by
/// the gradient (Zimmer, Bruhn, Weickert et al. 2009), and a smoothness that image edges weaken and the
/// proxy's outline stops. Coarse to fine with warps; each warp is linearised once and relaxed by red-black
/// SOR (flow_sweep.h).
///
/// FlowImage::state says where a picture is evidence: what is not an image's own in *both* pictures has no
/// data and takes the smooth continuation of its surroundings; outside the first picture's domain the field
/// is 0 and nothing is computed.
///
/// Presets: "quality" (spline warps, eight at each level: for pictures of a film) and "fast", the default
/// (bilinear warps, two at full size, one more at each coarser level up to eight, and a smoother field: for
/// projections of photographs, docs/adr/0163). FlowOptions::finest_scale > 0 stops at that level; the field
/// is then enlarged along the picture's edges (guided upsampling, Kopf et al. 2007).
///
/// An initial field (the last picture's, say) takes the place of the coarse levels. Deterministic: the same
/// bytes on every instruction set and at any thread count. Once pictures of a size have been seen nothing is
/// allocated for others of that size or smaller, on one thread.
Result<std::unique_ptr<FlowEstimator>> make_variational_flow(const FlowOptions& options);

}  // namespace floatstage::render
