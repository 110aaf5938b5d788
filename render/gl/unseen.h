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

 private:
  Unseen() = default;

  gl::Kernel known_, fill_;
  std::optional<gl::PullPush> around_;  // made by create()
};

}  // namespace floatstage::render
