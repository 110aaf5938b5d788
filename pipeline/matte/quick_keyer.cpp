#include "pipeline/matte/quick_keyer.h"

namespace floatstage::pipeline {

Result<Matte> QuickKeyer::key(const Frame& photograph) {
  std::unique_ptr<matting::LiveKey> mine;
  {
    const std::lock_guard lock(mutex_);
    if (!idle_.empty()) {
      mine = std::move(idle_.back());
      idle_.pop_back();
    }
  }
  if (!mine) mine = std::make_unique<matting::LiveKey>(*keyer_);
  Result<Matte> matte = mine->key(photograph);
  const std::lock_guard lock(mutex_);
  idle_.push_back(std::move(mine));
  return matte;
}

}  // namespace floatstage::pipeline
