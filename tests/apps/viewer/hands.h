#pragma once

#include "apps/viewer/window/input_event.h"

/// What hands do, for tests without a window.
namespace floatstage::apps {

inline InputEvent at(InputEvent::Kind kind, double x, double y, int button = 0) {
  InputEvent e;
  e.kind = kind, e.x = x, e.y = y, e.button = button;
  return e;
}

inline InputEvent key(int which, bool repeated = false) {
  InputEvent e;
  e.kind = InputEvent::Kind::Key, e.key = which, e.repeated = repeated;
  return e;
}

}  // namespace floatstage::apps
