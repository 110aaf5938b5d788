#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/rig.h"
#include "matting/labels/label_palette.h"
#include "pipeline/label_record.h"
#include "pipeline/matte/label_correction.h"
#include "pipeline/matte/label_givens.h"
#include "pipeline/matte/label_instant.h"

namespace floatstage::pipeline {

/// What is not to be trusted of labels that are followed, a sentence each with camera and frame. A sentence
/// that holds in several frames is one doubt.
class LabelDoubts {
 public:
  /// `rig` and `givens` outlive it. `names`: of the labels.
  LabelDoubts(const Rig& rig, std::vector<std::string> names, const LabelGivens& givens);

  /// Cameras without which the hull was carved.
  void disbelieved(const LabelInstant& instant);
  /// A word that nobody can be meant by.
  void nowhere(const NowhereWord& word, int frame);
  /// Labels that are one body to all cameras and have the same colours.
  void merged(const LabelInstant& instant, const matting::LabelPalette& palette);
  /// Labels of which nothing is left.
  void loss(const LabelInstant& instant);
  /// Words that turned nothing but what they mark.
  void unheard(const LabelCorrection& correction, const std::vector<std::uint8_t>& voxels,
               const LabelInstant& instant);
  /// Labels from which a word about another one took nearly all.
  void taken(const LabelCorrection& correction, const std::vector<std::uint8_t>& voxels,
             const LabelInstant& instant);
  /// Labels that are not the same from the frames given before and after.
  void meeting(const LabelInstant& onward, const LabelInstant& backward);

  const std::vector<LabelDoubt>& all() const { return all_; }

 private:
  void add(const std::string& why, const std::string& serial, int frame);
  int most_hidden(const LabelInstant& instant, int label) const;

  const Rig& rig_;
  const std::vector<std::string> names_;
  const LabelGivens& givens_;
  std::vector<LabelDoubt> all_;
  std::map<std::string, std::set<int>> doubted_;  // by why: frames, which may be met twice
};

}  // namespace floatstage::pipeline
