#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "apps/viewer/play/frame_clock.h"
#include "capture/sound/sound_output.h"
#include "capture/sound/sound_reader.h"
#include "capture/take.h"

namespace floatstage::apps {

/// Plays a take's sound, as it was recorded, on a thread that keeps the output fed while pictures are drawn.
/// What has been heard says which picture is due: the sound device's clock leads. Any thread.
class SoundPlayer {
 public:
  enum class Feeding { OwnThread, ByHand };

  /// The take's tracks of sound; none where it has none, or where none opens. `problem` gets why.
  static std::unique_ptr<SoundPlayer> of_take(const capture::TakeReader& take,
                                              std::unique_ptr<capture::SoundOutput> output,
                                              std::string& problem, Feeding feeding = Feeding::OwnThread);
  ~SoundPlayer();
  SoundPlayer(const SoundPlayer&) = delete;
  SoundPlayer& operator=(const SoundPlayer&) = delete;

  const FrameClock& clock() const { return clock_; }
  /// Names of the tracks that open, in the take's order.
  const std::vector<std::string>& tracks() const { return names_; }
  int chosen() const;
  /// Goes on in another track.
  void choose(int track);
  void set_gain(float gain);  ///< 0 is silent, 1 as it was recorded

  /// Plays from `from` on, s after the first frame; at the end it falls silent, or with `loop` begins again.
  void play(double from, bool loop);
  /// Whether the end is one, from now on.
  void set_loop(bool loop);
  void stop();  ///< silent at once
  bool plays() const;
  /// What is heard now, s after the first frame: where it was begun until anything is heard, up to its end.
  /// Absent while nothing plays.
  std::optional<double> heard();
  /// Of the output's own clock (SoundOutput::clock()).
  double output_clock();
  /// Fills the output: by hand only.
  void feed();
  /// Why nothing is heard any more: the device is gone. Once.
  std::optional<std::string> take_problem();

 private:
  // A stretch of the take, and of what was written since the output's last drop.
  struct Stretch {
    std::int64_t first = 0;  // sample written
    double from = 0;         // s after the first frame
  };
  struct Track {
    std::unique_ptr<capture::SoundReader> reader;
    std::unique_ptr<capture::PlayOut> out;
    int channels = 1;
  };

  SoundPlayer(const capture::TakeReader& take, std::unique_ptr<capture::SoundOutput> output);
  void open_tracks(const capture::TakeReader& take, std::string& problem);
  std::optional<double> heard_now();
  void begin(double from);
  Result<void> fill();
  Result<void> write(std::int64_t samples);
  void fails(const Error& error);
  void run();

  const FrameClock clock_;
  std::vector<std::string> names_;
  std::vector<Track> tracks_;

  mutable std::mutex mutex_;  // guards everything below
  std::condition_variable changed_;
  std::unique_ptr<capture::SoundOutput> output_;
  std::size_t chosen_ = 0;
  float gain_ = 1;
  bool plays_ = false, loop_ = false, ending_ = false, written_all_ = false;
  std::int64_t written_ = 0;  // samples, since the output's last drop
  std::int64_t until_ = 0;    // where the last stretch ends
  std::deque<Stretch> stretches_;
  std::vector<float> levels_, both_;
  std::optional<std::string> problem_;
  std::thread thread_;
};

}  // namespace floatstage::apps
