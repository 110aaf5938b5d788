#pragma once

#include <span>
#include <vector>

#include "core/image.h"
#include "core/rig.h"
#include "pipeline/matte/consistent.h"
#include "recon/shared_view.h"

namespace floatstage::pipeline {

/// What the turns ended with in one camera, at their size. Empty without a photograph.
struct ViewEvidence {
  Image label;                ///< 0 or 255
  std::vector<float> odds;    ///< by colours
  std::vector<float> others;  ///< by the other cameras, 0: half of them
};

/// In what judge() says where the other cameras deny what one has: the hull of the mattes says it too.
inline constexpr const char* kDeniedByOthers = "denied by the others";

/// Measures every camera and says in words what may be wrong: cameras that do not look where the others do,
/// that see no subject or hardly any, that lack or add much against the others, whose colours do not tell;
/// subjects that fill or leave pictures; cameras that all look from one side. Fills `views`, `remarks` and
/// `trusted`.
void judge(const Rig& rig, const recon::SharedView& shared, std::span<const ViewEvidence> evidence,
           ConsistentMattes& mattes);

}  // namespace floatstage::pipeline
