#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/matte.h"
#include "core/rig.h"

namespace floatstage::recon {

/// A rig and one instant's mattes.
struct MatteSet {
  Rig rig;
  std::vector<Matte> mattes;
};

/// Loads of the shared data sets; they throw std::runtime_error with the reason, which a test reports as its
/// failure. 19 views: brighter than `grey`, closed, largest component.
MatteSet load_temple_ring(const std::filesystem::path& folder, int grey = 12);
MatteSet load_temple_sparse_ring(const std::filesystem::path& folder);  ///< 16 views, the same way
MatteSet load_green_dome(
    const std::filesystem::path& folder);  ///< 20 cameras with the mattes given beside the images
/// 31 cameras around two players, of which four have no mask.
MatteSet load_basketball(const std::filesystem::path& folder, const std::string& frame);
MatteSet load_vacancy_bunny(const std::filesystem::path& folder);

/// Only the cameras with these indices.
MatteSet subset(const MatteSet& set, const std::vector<int>& cameras);

}  // namespace floatstage::recon
