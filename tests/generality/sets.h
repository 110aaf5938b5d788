#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/image.h"
#include "core/matte.h"
#include "core/rig.h"

namespace floatstage::generality {

/// One instant (or, of a single camera, a few) of one stage, with what somebody else says is subject.
struct StageSet {
  Rig rig;
  std::vector<std::vector<Image>> pictures;  ///< [frame][camera], RGB
  std::vector<Image> plates;                 ///< [camera], or none at all
  std::vector<Matte> truth;                  ///< [camera], of frame 0; empty where nobody knows
};

/// A row of the table.
struct SetName {
  std::string name;
  std::filesystem::path data;               ///< its folder; empty for the studio's stages
  std::function<StageSet(bool full)> load;  ///< full: pictures of their own size; else the short form
};

/// All stages of the synthetic studio (8 cameras, noise of one step, plates) and all recorded sets that show
/// a subject and come with somebody's mattes. Short form: pictures of 320 pixels at most a side. The load
/// throws std::runtime_error with the reason.
///
/// What is truth: exact in the studio; in the domes and the basketball court the given mattes, which have
/// faults that can be seen; of the Middlebury sets the plain threshold by which they key, closed, its largest
/// part.
std::vector<SetName> all_sets();

/// Writes the set as a take, with its plates.
void write_take(const StageSet& set, const std::filesystem::path& folder);

}  // namespace floatstage::generality
