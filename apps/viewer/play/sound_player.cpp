// docs/adr/0279-pictures-follow-the-sound-device.md

#include "apps/viewer/play/sound_player.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "capture/sound/play_out.h"
#include "capture/sound/time_code.h"
#include "core/text.h"
#include "pipeline/film_sound.h"

namespace floatstage::apps {
namespace {

using capture::kOutputChannels;
using capture::kPlayOutRate;

constexpr auto kLook = std::chrono::milliseconds(10);  // how often the output is filled
constexpr std::int64_t kAtOnce = 1024, kFade = kPlayOutRate / 200;

std::int64_t samples_of(double seconds) { return std::llround(seconds * kPlayOutRate); }

}  // namespace

std::unique_ptr<SoundPlayer> SoundPlayer::of_take(const capture::TakeReader& take,
                                                  std::unique_ptr<capture::SoundOutput> output,
                                                  std::string& problem, Feeding feeding) {
  std::unique_ptr<SoundPlayer> player(new SoundPlayer(take, std::move(output)));
  player->open_tracks(take, problem);
  if (player->tracks_.empty()) return nullptr;
  if (!player->clock_.known()) {
    problem = text(take.layout().folder().string(), ": its pictures have no times that sound could follow");
    return nullptr;
  }
  if (feeding == Feeding::OwnThread) player->thread_ = std::thread([p = player.get()] { p->run(); });
  return player;
}

SoundPlayer::SoundPlayer(const capture::TakeReader& take, std::unique_ptr<capture::SoundOutput> output)
    : clock_(take), output_(std::move(output)) {}

SoundPlayer::~SoundPlayer() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void SoundPlayer::open_tracks(const capture::TakeReader& take, std::string& problem) {
  const Result<std::vector<capture::SoundTrack>> tracks = capture::load_sound_tracks(take.layout());
  const Result<std::optional<capture::TimeCode>> code = capture::load_time_code(take.layout());
  if (!tracks || !code) {
    problem = tracks ? code.error().message : tracks.error().message;
    return;
  }
  for (const capture::SoundTrack& track : *tracks) {
    const std::vector<int> channels = pipeline::heard_channels(track, *code ? (*code)->from : "");
    if (channels.empty()) continue;
    Track opened;
    Result<std::unique_ptr<capture::SoundReader>> reader = capture::SoundReader::open(take.layout(), track);
    if (!reader) {
      problem = reader.error().message;
      continue;
    }
    opened.reader = std::move(*reader);
    Result<std::unique_ptr<capture::PlayOut>> out = capture::PlayOut::create(*opened.reader, channels);
    if (!out) {
      problem = out.error().message;
      continue;
    }
    opened.out = std::move(*out);
    opened.channels = static_cast<int>(channels.size());
    tracks_.push_back(std::move(opened));
    names_.push_back(track.name);
  }
}

int SoundPlayer::chosen() const {
  const std::lock_guard lock(mutex_);
  return static_cast<int>(chosen_);
}

void SoundPlayer::choose(int track) {
  const std::lock_guard lock(mutex_);
  const auto wanted = static_cast<std::size_t>(track);
  if (wanted >= tracks_.size() || wanted == chosen_) return;
  const std::optional<double> at = heard_now();
  chosen_ = wanted;
  if (at && plays_) begin(*at);
}

void SoundPlayer::set_gain(float gain) {
  const std::lock_guard lock(mutex_);
  if (gain == gain_) return;
  const bool mute = gain == 0 || gain_ == 0;
  const std::optional<double> at = mute ? heard_now() : std::nullopt;
  gain_ = gain;
  // Silence waits for nothing that was written already.
  if (at && plays_) begin(*at);
}

void SoundPlayer::play(double from, bool loop) {
  {
    const std::lock_guard lock(mutex_);
    loop_ = loop;
    plays_ = true;
    begin(from);
  }
  changed_.notify_all();
}

void SoundPlayer::set_loop(bool loop) {
  const std::lock_guard lock(mutex_);
  loop_ = loop;
}

void SoundPlayer::stop() {
  const std::lock_guard lock(mutex_);
  if (!plays_) return;
  plays_ = false;
  output_->drop();
}

bool SoundPlayer::plays() const {
  const std::lock_guard lock(mutex_);
  return plays_;
}

std::optional<double> SoundPlayer::heard() {
  const std::lock_guard lock(mutex_);
  return heard_now();
}

std::optional<double> SoundPlayer::heard_now() {
  if (!plays_) return std::nullopt;
  const Result<std::int64_t> heard = output_->heard();
  if (!heard) {
    fails(heard.error());
    return std::nullopt;
  }
  if (written_all_ && *heard >= until_) {
    plays_ = false;
    return clock_.length();
  }
  while (stretches_.size() > 1 && stretches_[1].first <= *heard) stretches_.pop_front();
  const Stretch& now = stretches_.front();
  return now.from + static_cast<double>(*heard - now.first) / kPlayOutRate;
}

double SoundPlayer::output_clock() {
  const std::lock_guard lock(mutex_);
  return output_->clock();
}

std::optional<std::string> SoundPlayer::take_problem() {
  const std::lock_guard lock(mutex_);
  return std::exchange(problem_, std::nullopt);
}

void SoundPlayer::feed() {
  const std::lock_guard lock(mutex_);
  if (!plays_) return;
  if (const Result<void> ok = fill(); !ok) fails(ok.error());
}

void SoundPlayer::begin(double from) {
  from = std::clamp(from, 0.0, clock_.length());
  output_->drop();
  written_ = 0;
  written_all_ = false;
  until_ = samples_of(clock_.length() - from);
  stretches_ = {{0, from}};
  tracks_[chosen_].out->seek(clock_.begin() + Nanoseconds{std::llround(from * 1e9)});
}

Result<void> SoundPlayer::fill() {
  Result<std::int64_t> room = output_->room();
  if (!room) return forward(room);
  while (*room > 0 && !written_all_) {
    if (written_ == until_) {
      if (!loop_ || samples_of(clock_.length()) < 1) {
        written_all_ = true;
        return {};
      }
      stretches_.push_back({until_, 0});
      until_ += samples_of(clock_.length());
      tracks_[chosen_].out->seek(clock_.begin());
    }
    const std::int64_t some = std::min({*room, until_ - written_, kAtOnce});
    if (Result<void> ok = write(some); !ok) return ok;
    *room -= some;
  }
  return {};
}

Result<void> SoundPlayer::write(std::int64_t samples) {
  const Track& track = tracks_[chosen_];
  const auto count = static_cast<std::size_t>(samples), width = static_cast<std::size_t>(track.channels);
  levels_.resize(count * width);
  if (Result<void> ok = track.out->read(levels_); !ok) return ok;
  both_.resize(count * kOutputChannels);
  for (std::size_t i = 0; i < count; ++i) {
    // What begins in the middle of a wave clicks.
    const auto from_begin = written_ + static_cast<std::int64_t>(i);
    const float fade = from_begin < kFade ? static_cast<float>(from_begin) / kFade : 1;
    for (std::size_t c = 0; c < kOutputChannels; ++c)
      both_[i * kOutputChannels + c] = gain_ * fade * levels_[i * width + std::min(c, width - 1)];
  }
  if (Result<void> ok = output_->write(both_); !ok) return ok;
  written_ += samples;
  return {};
}

void SoundPlayer::fails(const Error& error) {
  plays_ = false;
  problem_ = error.message;
}

void SoundPlayer::run() {
  std::unique_lock lock(mutex_);
  while (!ending_) {
    if (plays_)
      if (const Result<void> ok = fill(); !ok) fails(ok.error());
    if (plays_)
      changed_.wait_for(lock, kLook);
    else
      changed_.wait(lock, [&] { return ending_ || plays_; });
  }
}

}  // namespace floatstage::apps
