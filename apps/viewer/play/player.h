#pragma once

#include <memory>

#include "apps/viewer/play/play.h"
#include "capture/take.h"

namespace floatstage::apps {

/// The player in its window: scene, controls, time line. GL thread only.
class Player {
 public:
  /// What of the options is wrong, before a window is there: InvalidArgument; NotFound when the take has no
  /// meshes.
  static Result<void> check(const PlayOptions& options, const capture::TakeReader& take);
  /// In the window that is current. `options` and `take` outlive it. Errors: those of check().
  static Result<std::unique_ptr<Player>> open(const PlayOptions& options, capture::TakeReader& take);
  virtual ~Player() = default;

  /// One frame of the user interface. Errors are shown, not returned: the window stays.
  virtual void frame() = 0;
  virtual bool stands() const = 0;  ///< the picture of the present frame is there
  virtual bool busy() const = 0;
  virtual int frame_number() const = 0;
  virtual void go_to(int frame) = 0;
  virtual void show_status(std::string status) = 0;
  /// Mattes have changed.
  virtual void forget_scenes() = 0;
};

}  // namespace floatstage::apps
