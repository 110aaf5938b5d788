#pragma once

#include <string>
#include <vector>

#include "apps/viewer/play/sound_player.h"
#include "apps/viewer/window/time_line.h"

namespace floatstage::apps {

/// Which picture was on the window when what was heard.
struct ShownWhileHeard {
  int frame = 0;
  double output = 0;  ///< s of the output's clock: in a file, where that is
  double heard = 0;   ///< s after the take's first frame
};

/// Where sound is heard its device moves the time line on, so that pictures and sound stay together however
/// long pictures take: ears notice what eyes do not. It is heard where the take plays as it was recorded, and
/// silent while a hand seeks, at other speeds, and where a camera path says what is shown. Without a window.
class SoundLead {
 public:
  /// `player`: null where nothing is to be heard. It outlives this.
  explicit SoundLead(SoundPlayer* player) : player_(player) {}

  /// Moves `time` on, `elapsed` seconds after the last call, `now` on the same clock. `ahead`: s until what
  /// is chosen now is seen. `by_path`: something else moves the time line.
  void advance(TimeLine& time, double elapsed, double now, double ahead, bool by_path);
  bool heard() const { return player_ != nullptr && player_->plays(); }

 private:
  bool follow(TimeLine& time, double ahead);

  SoundPlayer* player_;      // null once its device is gone
  long seeks_ = -1;          // of the time line, when this left it
  double touched_ = -1e300;  // when a hand had moved it
};

}  // namespace floatstage::apps
