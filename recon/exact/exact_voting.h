#pragma once

#include <span>
#include <vector>

#include "recon/exact/exact_method.h"

namespace floatstage::recon {

/// Share of a matte's subject (0 … 1) that the mesh's silhouette does not reach, per camera, looked at on a
/// coarse grid of pixels; 0 for an empty matte.
std::vector<double> missed_shares(const Rig& rig, std::span<const Matte> mattes, const Mesh& mesh,
                                  int threads);

/// Cameras whose mattes lack a part of the subject, worst first. A part missing from one matte is carved away
/// for all: then many others see subject where the strict hull has none, and leaving the guilty one out heals
/// them. Looks only when the strict hull misses more than 2 % of at least half of the mattes, and names a
/// camera only when the excess over 2 % falls to a fifth without it. At most a quarter of the cameras.
std::vector<int> find_bad_views(const Rig& rig, HullInput& input, const Mesh& strict, int threads,
                                HullWorkspace::Impl& workspace);

}  // namespace floatstage::recon
