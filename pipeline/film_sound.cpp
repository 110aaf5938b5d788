// What is heard in a film: docs/adr/0269-sound-of-a-take.md

#include "pipeline/film_sound.h"

#include <algorithm>
#include <cmath>

#include "capture/sound/sound_reader.h"
#include "capture/sound/time_code.h"
#include "core/text.h"

namespace floatstage::pipeline {
namespace {

using capture::kPlayOutRate;

constexpr double kShortest = 1;        // s: of a cut that no jump bounds; slower ones are slow motion
constexpr double kShortestJump = 0.2;  // s: of one between jumps; shorter ones are fast motion
constexpr double kFade = 0.005;        // s: a jump of the sound does not click
constexpr double kMostClocks = 1e-3;   // that clocks differ by

// When a frame was taken: by the camera that was first. Nothing beyond the side files.
std::optional<Timestamp> time_of(const capture::TakeReader& take, int frame) {
  std::optional<Timestamp> time;
  for (std::size_t c = 0; c < take.rig().cameras.size(); ++c) {
    const std::vector<FrameRow>& rows = take.rows(static_cast<int>(c));
    if (frame < 0 || static_cast<std::size_t>(frame) >= rows.size()) continue;
    const Timestamp own = rows[static_cast<std::size_t>(frame)].info.exposure_start;
    time = time ? std::min(*time, own) : own;
  }
  return time;
}

struct Stretch {
  std::size_t first = 0, end = 0;  // pictures
};

// Pictures [first, end) as one cut: their frames lie on a line in the film and on one in the take's time.
SoundCut cut_of(const Stretch& s, const std::vector<int>& frames,
                const std::vector<std::optional<Timestamp>>& times, double frame_rate, double take_rate) {
  // The frame that is on at a time of the film is floor(ahead + time × rate).
  double ahead = -1e300, mean_frame = 0, mean_time = 0, spread = 0, both = 0;
  const Timestamp origin = *times[s.first];
  const auto n = static_cast<double>(s.end - s.first);
  for (std::size_t p = s.first; p < s.end; ++p) {
    ahead = std::max(ahead, frames[p] - static_cast<double>(p) / frame_rate * take_rate);
    mean_frame += frames[p] / n;
    mean_time += seconds(*times[p] - origin) / n;
  }
  for (std::size_t p = s.first; p < s.end; ++p) {
    spread += (frames[p] - mean_frame) * (frames[p] - mean_frame);
    both += (frames[p] - mean_frame) * (seconds(*times[p] - origin) - mean_time);
  }
  double period = spread > 0 ? both / spread : 1 / take_rate;
  if (std::abs(period * take_rate - 1) > kMostClocks) period = 1 / take_rate;
  SoundCut cut;
  const auto sample_of = [&](std::size_t picture) {
    return std::llround(static_cast<double>(picture) / frame_rate * kPlayOutRate);
  };
  cut.first = sample_of(s.first);
  cut.end = sample_of(s.end);
  const double frame = ahead + static_cast<double>(s.first) / frame_rate * take_rate;
  cut.from = origin + Nanoseconds{std::llround((mean_time + (frame - mean_frame) * period) * 1e9)};
  cut.speed = period * take_rate;
  return cut;
}

class OfTake final : public FilmSounds {
 public:
  OfTake(std::unique_ptr<capture::SoundReader> reader, std::vector<SoundCut> cuts)
      : reader_(std::move(reader)), cuts_(std::move(cuts)) {}

  Result<void> open(const std::vector<int>& channels, std::int64_t samples) {
    Result<std::unique_ptr<capture::PlayOut>> out = capture::PlayOut::create(*reader_, channels);
    if (!out) return forward(out);
    out_ = std::move(*out);
    sound_.channels = static_cast<int>(channels.size());
    sound_.samples = samples;
    sound_.read = [this](std::int64_t first, std::span<float> to) { return read(first, to); };
    return {};
  }
  const capture::FilmSound& sound() const override { return sound_; }
  std::string track() const override { return reader_->track().name; }
  double seconds() const override {
    std::int64_t heard = 0;
    for (const SoundCut& cut : cuts_) heard += cut.end - cut.first;
    return static_cast<double>(heard) / kPlayOutRate;
  }

 private:
  Result<void> read(std::int64_t first, std::span<float> to) {
    std::fill(to.begin(), to.end(), 0.f);
    const std::int64_t width = sound_.channels, end = first + static_cast<std::int64_t>(to.size()) / width;
    for (const SoundCut& cut : cuts_) {
      const std::int64_t a = std::max(first, cut.first), b = std::min(end, cut.end);
      if (a >= b) continue;
      if (a == cut.first) out_->seek(cut.from, cut.speed);
      const std::span<float> part = to.subspan(static_cast<std::size_t>((a - first) * width),
                                               static_cast<std::size_t>((b - a) * width));
      if (Result<void> ok = out_->read(part); !ok) return ok;
      constexpr double kFadeSamples = kFade * kPlayOutRate;
      for (std::int64_t i = a; i < b; ++i) {
        const auto from_edge = static_cast<double>(std::min(i - cut.first, cut.end - 1 - i));
        if (from_edge >= kFadeSamples) continue;
        for (std::int64_t c = 0; c < width; ++c)
          part[static_cast<std::size_t>((i - a) * width + c)] *= static_cast<float>(from_edge / kFadeSamples);
      }
    }
    return {};
  }

  const std::unique_ptr<capture::SoundReader> reader_;
  const std::vector<SoundCut> cuts_;
  std::unique_ptr<capture::PlayOut> out_;
  capture::FilmSound sound_;
};

}  // namespace

std::vector<int> heard_channels(const capture::SoundTrack& track, const std::string& time_code) {
  std::vector<int> channels;
  for (int c = 0; c < track.channels && channels.size() < 2; ++c)
    if (time_code != text("ltc ", track.name, ":", c)) channels.push_back(c);
  return channels;
}

std::vector<SoundCut> sound_cuts(const capture::TakeReader& take, const std::vector<int>& frames,
                                 double frame_rate) {
  const double rate = take.manifest().frame_rate;
  if (!(rate > 0) || !(frame_rate > 0) || frames.empty()) return {};
  std::vector<std::optional<Timestamp>> times;
  for (const int frame : frames) times.push_back(time_of(take, frame));
  const double step = rate / frame_rate;  // frames a picture
  const auto ahead = [&](std::size_t p) { return frames[p] - static_cast<double>(p) * step; };
  const auto goes_on = [&](std::size_t p) {
    if (!times[p] || !times[p - 1]) return false;
    const int frames_on = frames[p] - frames[p - 1];
    return std::abs(frames_on - step) < 1 &&
           std::abs(seconds(*times[p] - *times[p - 1]) * rate - frames_on) < 0.5;
  };
  std::vector<SoundCut> cuts;
  const auto pictures_in = [&](double s) { return static_cast<std::size_t>(std::ceil(s * frame_rate)); };
  for (std::size_t begin = 0; begin < frames.size();) {
    std::size_t end = begin + 1;
    while (end < frames.size() && goes_on(end)) ++end;
    // Between two jumps; inside of it the film may be slower or faster than the take.
    for (std::size_t first = begin; first < end;) {
      double low = ahead(first), high = low;
      std::size_t next = first + 1;
      for (; next < end; ++next) {
        low = std::min(low, ahead(next));
        high = std::max(high, ahead(next));
        constexpr double kRounding = 1e-3;
        if (high - low > 1 - kRounding) break;
      }
      const bool whole = first == begin && next == end;
      const std::size_t least = std::min(pictures_in(whole ? kShortestJump : kShortest), frames.size());
      if (times[first] && next - first >= least && next - first > 1)
        cuts.push_back(cut_of({first, next}, frames, times, frame_rate, rate));
      first = next;
    }
    begin = end;
  }
  return cuts;
}

Result<std::unique_ptr<FilmSounds>> FilmSounds::open(const capture::TakeReader& take,
                                                     const std::vector<int>& frames, double frame_rate,
                                                     const std::string& name) {
  const Result<std::vector<capture::SoundTrack>> tracks = capture::load_sound_tracks(take.layout());
  if (!tracks) return forward(tracks);
  if (tracks->empty() && name.empty()) return std::unique_ptr<FilmSounds>();
  const Result<capture::SoundTrack> track = capture::sound_track_named(*tracks, name);
  if (!track)
    return fail(track.error().code, text(take.layout().folder().string(), ": ", track.error().message));
  const Result<std::optional<capture::TimeCode>> code = capture::load_time_code(take.layout());
  if (!code) return forward(code);
  const std::vector<int> channels = heard_channels(*track, *code ? (*code)->from : "");
  if (channels.empty()) return std::unique_ptr<FilmSounds>();
  std::vector<SoundCut> cuts = sound_cuts(take, frames, frame_rate);
  if (cuts.empty()) return std::unique_ptr<FilmSounds>();
  Result<std::unique_ptr<capture::SoundReader>> reader = capture::SoundReader::open(take.layout(), *track);
  if (!reader) return forward(reader);
  auto sounds = std::make_unique<OfTake>(std::move(*reader), std::move(cuts));
  const auto samples = std::llround(static_cast<double>(frames.size()) / frame_rate * kPlayOutRate);
  if (Result<void> ok = sounds->open(channels, samples); !ok) return forward(ok);
  return std::unique_ptr<FilmSounds>(std::move(sounds));
}

}  // namespace floatstage::pipeline
