#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/result.h"
#include "core/take_layout.h"

namespace floatstage::pipeline {

/// What of a take's derived files one item works on.
struct ViewPart {
  std::vector<std::string> cameras;  ///< serials: whose mattes
  std::vector<int> frames;           ///< whose mattes and meshes
};

/// A folder that is the take to whoever opens it: links to what was recorded and to the derived files of
/// `part`, and copies of the records that know of no others. What is written into it replaces links and
/// leaves the take alone, so any number of items work beside one another. `view` is an empty folder. Io; what
/// load_matte_record() and load_mesh_record() say.
Result<void> make_view(const TakeLayout& take, const ViewPart& part, const std::filesystem::path& view);

/// Copies what was written into a view (mattes, meshes, pictures of faults) and its records to the new folder
/// `done`, whole or not at all. One that is there already was made by somebody else from the same, and stays.
/// Returns the bytes. Io.
Result<std::uint64_t> deliver(const TakeLayout& view, const std::filesystem::path& done);

/// Puts files of mattes that lie in these folders, and what their records say of them, into the take: who
/// calls has claimed it. Stopped at any moment and called again it ends alike. What somebody else put there
/// meanwhile stays. Returns how many mattes were put. `stale`: see Plan. Io, BadData.
Result<int> gather_mattes(const TakeLayout& take, const std::vector<std::filesystem::path>& done,
                          const std::map<std::string, std::set<int>>& stale);
/// Likewise meshes, mattes that were healed for them, and the pictures of the worst faults of all.
Result<int> gather_meshes(const TakeLayout& take, const std::vector<std::filesystem::path>& done);

}  // namespace floatstage::pipeline
