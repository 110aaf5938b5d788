#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "capture/take.h"
#include "core/matte.h"
#include "core/result.h"

namespace floatstage::pipeline {

/// Which of a take's labels are to be seen: `only` these or all `without` those; both empty: all, as it is.
struct LabelChoice {
  std::vector<std::string> only, without;
  bool everybody() const { return only.empty() && without.empty(); }
};

/// A take in which nobody is but the chosen labels: mattes are theirs, and meshes those of their hulls
/// (TakeLayout::with_labels()). Errors: those of TakeReader::open() and choose_labels(); NotFound where the
/// labels are older than the mattes that they divide.
Result<std::unique_ptr<capture::TakeReader>> open_chosen(const std::filesystem::path& take,
                                                         const LabelChoice& choice);
/// The same of an open take.
Result<std::unique_ptr<capture::TakeReader>> choose(std::unique_ptr<capture::TakeReader> take,
                                                    const LabelChoice& choice);

/// What carves the chosen labels' hull: their mattes, and where somebody else is seen, what of them may be
/// behind. That is where voxels of the hull of all are seen, by more of the cameras before which they are in
/// front as theirs than as others'. `mattes`: load_mattes() of that take, which it is for a take that was not
/// chosen from. docs/adr/0300.
Result<std::vector<Matte>> silhouettes_of_labels(const capture::TakeReader& take, int frame,
                                                 std::vector<Matte> mattes, int threads);

}  // namespace floatstage::pipeline
