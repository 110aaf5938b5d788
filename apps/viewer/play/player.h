#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "apps/viewer/play/canvas.h"
#include "apps/viewer/play/play.h"
#include "apps/viewer/play/sound_lead.h"
#include "apps/viewer/window/input_event.h"
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

  /// One frame of the user interface, with what hands did since the last. Errors are shown, not returned: the
  /// window stays.
  virtual void frame(std::span<const InputEvent> input) = 0;
  /// All of that frame took so long, until the window showed it.
  virtual void frame_took(double seconds) = 0;
  /// Asked while a full picture is drawn: true gives it up for what hands want (Canvas::give_up_when()).
  virtual void give_up_when(std::function<bool()> hand_waits) = 0;
  virtual bool gave_up() const = 0;  ///< the last frame()'s picture was
  virtual bool stands() const = 0;   ///< the full picture of the present frame is there
  virtual bool busy() const = 0;
  virtual int frame_number() const = 0;
  virtual void go_to(int frame) = 0;
  virtual void show_status(std::string status) = 0;
  virtual const CanvasTimes& times() const = 0;
  /// Which pictures were shown while sound was heard, the first ones.
  virtual const std::vector<ShownWhileHeard>& shown_while_heard() const = 0;
  /// Mattes have changed.
  virtual void forget_scenes() = 0;
};

}  // namespace floatstage::apps
