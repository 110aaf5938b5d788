#pragma once

#include <cstddef>
#include <vector>

#include "core/rig.h"

namespace floatstage::pipeline {

/// Cameras that are asked against one hull of all others. One by one they would need a hull each; of ten
/// cameras and more a fifth can be missed: what the rest leaves is a little larger, so that less sticks out
/// of it, and nothing more. Those of one group stand apart, as their order around the rig's axis tells. Large
/// groups are as large as leaves eight cameras, or half of them.
class CameraGroups {
 public:
  explicit CameraGroups(const Rig& rig, bool large = false);
  std::size_t count() const { return count_; }
  std::size_t of(std::size_t camera) const { return group_[camera]; }

 private:
  std::size_t count_ = 0;
  std::vector<std::size_t> group_;
};

}  // namespace floatstage::pipeline
