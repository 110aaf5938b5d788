#pragma once

namespace floatstage::apps {

/// What a hand did, in the order in which it did it: nothing is lost between two pictures of the window,
/// however slow they are. Positions are px of the window, its top-left corner at (0, 0).
struct InputEvent {
  enum class Kind { Press, Move, Release, Wheel, Key };
  Kind kind = Kind::Move;
  double x = 0, y = 0;
  int button = 0;    ///< Press, Release: 0 left, 1 right, 2 middle
  double wheel = 0;  ///< Wheel: notches away from the hand
  int key = 0;  ///< Key: a capital letter, a digit, another character of the US keyboard, or one of kKey…
  bool repeated = false;  ///< Key: it is held, and this is not its first event
  bool control = false, shift = false;
};

// GLFW's numbers; window.cpp checks that.
constexpr int kKeyEscape = 256, kKeyEnter = 257, kKeyTab = 258, kKeyDelete = 261, kKeyRight = 262,
              kKeyLeft = 263, kKeyHome = 268, kKeyEnd = 269, kKeyF3 = 292, kKeyF12 = 301;

}  // namespace floatstage::apps
