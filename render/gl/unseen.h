#pragma once

#include <optional>

#include "render/gl/pull_push.h"

namespace floatstage::render {

class Projection;
class ViewTarget;

/// What no camera of a view sees continues its surroundings. The passes of render/cpu/unseen.h.
class Unseen {
 public:
  static Result<Unseen> create();

  /// After a view is drawn into `target`, before it gets its opacity.
  void run(const Projection& projection, ViewTarget& target);

  /// A buffer with the last run's SeenPixels; the GPU writes it.
  const gl::Buffer& seen() const { return seen_; }

 private:
  Unseen() = default;

  gl::Kernel known_, fill_;
  std::optional<gl::PullPush> around_;  // made by create()
  gl::Buffer seen_;
};

}  // namespace floatstage::render
