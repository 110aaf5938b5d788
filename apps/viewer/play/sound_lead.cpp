#include "apps/viewer/play/sound_lead.h"

#include <algorithm>
#include <cmath>

namespace floatstage::apps {
namespace {

constexpr double kRest = 0.2;         // s that a hand rests before sound begins again
constexpr double kAsRecorded = 1e-3;  // of the speed

}  // namespace

void SoundLead::advance(TimeLine& time, double elapsed, double now, double ahead, bool by_path) {
  if (time.seeks() != seeks_ && seeks_ >= 0) touched_ = now;
  const bool audible = player_ != nullptr && time.playing && !by_path &&
                       std::abs(time.speed - 1) < kAsRecorded && now - touched_ >= kRest;
  if (!audible && player_ != nullptr) player_->stop();
  if (!audible || !follow(time, ahead))
    if (!by_path) time.advance(elapsed);
  seeks_ = time.seeks();
}

// Whether there was anything to follow.
bool SoundLead::follow(TimeLine& time, double ahead) {
  const FrameClock& clock = player_->clock();
  player_->set_loop(time.loop);
  if (!player_->plays()) player_->play(clock.seconds_at(time.position()), time.loop);
  const std::optional<double> heard = player_->heard();
  if (!heard) {  // the device is gone: who draws is told, and goes on without
    player_ = nullptr;
    return false;
  }
  if (!player_->plays()) {  // it has ended
    time.seek(time.frames() - 1);
    time.playing = false;
    return true;
  }
  double due = *heard + ahead;
  if (due >= clock.length()) due = time.loop ? std::fmod(due, clock.length()) : clock.length();
  const double position = clock.position_at(due), back = time.position() - position;
  // Pictures that were drawn more quickly than was expected do not go back.
  const double most_back = ahead > 0 ? clock.position_at(2 * ahead) + 1 : 0;
  if (back <= 0 || back > most_back) time.follow(position);
  return true;
}

}  // namespace floatstage::apps
