#include "pipeline/import/import_sound.h"

#include <algorithm>
#include <cmath>

#include "capture/sound/media_sound.h"
#include "capture/sound/sound_writer.h"
#include "core/take_layout.h"
#include "core/text.h"

namespace floatstage::pipeline {
namespace {

constexpr Nanoseconds kAround = milliseconds(1000);  // that is kept beside the pictures
constexpr Nanoseconds kUnbroken = milliseconds(40);  // of what containers with coarse times say
constexpr double kSameSpeed = 2e-3;                  // 29.97 and 30 are one speed, 24 and 25 are not

// From the video's own time to the take's.
class TakeTime {
 public:
  explicit TakeTime(const VideoTimes& times)
      : from_(times.first.value_or(Nanoseconds{})), to_(times.take_first) {
    const double video = times.last ? seconds(*times.last - from_) : 0;
    if (video > 0) speed_ = seconds(times.take_last - times.take_first) / video;
  }
  double speed() const { return speed_; }  // seconds of the take a second of the video
  Timestamp of(Nanoseconds video) const {
    return to_ + Nanoseconds{std::llround(static_cast<double>((video - from_).count) * speed_)};
  }

 private:
  Nanoseconds from_;
  Timestamp to_;
  double speed_ = 1;
};

// One track from where it is wanted on; whether there was anything.
Result<bool> copy_sound(const VideoSound& video, capture::MediaSound& sound, const TakeTime& time,
                        const capture::SoundTrack& track, const TakeLayout& take, const Progress* watch) {
  const Timestamp first = video.times.take_first - kAround, last = video.times.take_last + kAround;
  std::unique_ptr<capture::SoundWriter> writer;
  std::optional<Nanoseconds> expected;
  Timestamp stamped;
  const Nanoseconds often = milliseconds(1000);
  for (;;) {
    if (is_cancelled(watch)) return cancelled();
    const Result<capture::MediaSound::Block> block = sound.next();
    if (!block && block.error().code == ErrorCode::EndOfStream) break;
    if (!block)
      return fail(block.error().code, text(block.error().message, "; leave sound out with --no-sound"));
    const auto count = static_cast<std::int64_t>(block->samples.size()) / track.channels;
    const Timestamp now = time.of(block->time);
    if (now > last) break;
    if (now < first) continue;
    if (!writer) {
      Result<std::unique_ptr<capture::SoundWriter>> made = capture::SoundWriter::create(take, track);
      if (!made) return forward(made);
      writer = std::move(*made);
    }
    // Where its own times leave a hole, another run begins.
    const bool broken = expected && std::abs((block->time - *expected).count) > kUnbroken.count;
    if (!expected || broken || now - stamped >= often) {
      if (Result<void> ok = writer->stamp(writer->samples(), now, broken); !ok) return forward(ok);
      stamped = now;
    }
    if (Result<void> ok = writer->write(block->samples); !ok) return forward(ok);
    expected = block->time + Nanoseconds{count * 1'000'000'000 / track.rate};
  }
  if (!writer) return false;
  if (Result<void> ok = writer->finish(); !ok) return forward(ok);
  return true;
}

}  // namespace

Result<int> import_sound(const std::vector<VideoSound>& videos, const std::filesystem::path& folder,
                         std::vector<std::string>& notes, Progress* progress) {
  const TakeLayout take(folder);
  std::vector<capture::SoundTrack> tracks;
  ProgressPart part(progress, "sound", videos.size());
  for (const VideoSound& video : videos) {
    Result<std::unique_ptr<capture::MediaSound>> opened = capture::MediaSound::open(video.video);
    if (!opened)
      return fail(opened.error().code, text(opened.error().message, "; leave sound out with --no-sound"));
    part.advance();
    if (!*opened) continue;
    const TakeTime time(video.times);
    auto left_out = [&](const std::string& why) {
      notes.push_back(text("the sound of camera '", video.serial, "' is left out: ", why));
    };
    if (!video.times.first) {
      left_out("the video does not say when its pictures are shown");
      continue;
    }
    if (std::abs(time.speed() - 1) > kSameSpeed) {
      left_out(text("its pictures are shown ", 1 / time.speed(), " as fast as they were recorded"));
      continue;
    }
    const capture::SoundTrack track = {.name = video.serial,
                                       .rate = (*opened)->rate(),
                                       .channels = (*opened)->channels(),
                                       .bits = (*opened)->bits(),
                                       .from = video.video.filename().string()};
    const Result<bool> any = copy_sound(video, **opened, time, track, take, progress);
    if (!any) return forward(any);
    if (*any)
      tracks.push_back(track);
    else
      left_out("there is none while its pictures are shown");
  }
  if (!tracks.empty())
    if (Result<void> ok = capture::save_sound_tracks(tracks, take); !ok) return forward(ok);
  return static_cast<int>(tracks.size());
}

}  // namespace floatstage::pipeline
