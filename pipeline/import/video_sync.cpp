// docs/adr/0281-cameras-started-by-hand.md

#include "pipeline/import/video_sync.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "capture/sound/media_sound.h"
#include "core/parallel.h"
#include "core/text.h"
#include "pipeline/import/picture_stream.h"
#include "pipeline/onset_sync.h"

namespace floatstage::pipeline {
namespace {

// Sound's way through 14 m, and two pictures of 30 a second.
const OnsetMatch kClaps{
    .tolerance = 0.04, .separation = 0.08, .closure = 0.03, .event = "clap", .events = "claps"};
const OnsetMatch kFlashes{
    .tolerance = 0.07, .separation = 0.2, .closure = 0.1, .event = "flash", .events = "flashes"};

// When a video's pictures are shown, in its own time, and how bright they are.
struct Survey {
  std::vector<double> times, brightness;
  double nominal_rate = 0;

  double rate() const {
    const double mean = static_cast<double>(times.size() - 1) / (times.back() - times.front());
    constexpr double kSameRate = 1e-4;
    return std::abs(mean - nominal_rate) < kSameRate * nominal_rate ? nominal_rate : mean;
  }
};

double mean_of(const Image& picture) {
  return static_cast<double>(
             std::accumulate(picture.pixels.begin(), picture.pixels.end(), std::uint64_t{0})) /
         static_cast<double>(std::max<std::size_t>(picture.pixels.size(), 1));
}

Result<Survey> survey(const CameraMedia& media, const Progress* watch) {
  if (media.video.empty())
    return fail(ErrorCode::InvalidArgument,
                "has no video, which --sync needs of each camera; leave it out with "
                "--cameras, or leave --sync out");
  Result<PictureStream> stream = PictureStream::open(media, {});
  if (!stream) return forward(stream);
  Survey out;
  out.nominal_rate = stream->frame_rate();
  for (;;) {
    if (is_cancelled(watch)) return cancelled();
    const Result<std::optional<Image>> picture = stream->next();
    if (!picture) return forward(picture);
    if (!*picture) break;
    const std::optional<Nanoseconds> time = stream->last_time();
    if (!time || (!out.times.empty() && seconds(*time) <= out.times.back()))
      return fail(ErrorCode::BadData,
                  text(media.video.string(), ": picture ", out.times.size(),
                       " does not say when it is shown, or is shown before the one before; convert the video "
                       "(ffmpeg -i IN -c copy OUT.mkv), or leave --sync out"));
    out.times.push_back(seconds(*time));
    out.brightness.push_back(mean_of(**picture));
  }
  if (out.times.size() < 2)
    return fail(ErrorCode::BadData,
                text(media.video.string(), ": holds a single picture, which has no rate"));
  return out;
}

// All of a video's sound as one channel, from when on; holes are silent.
Result<std::vector<Onset>> claps_in(const std::filesystem::path& video, const Progress* watch) {
  Result<std::unique_ptr<capture::MediaSound>> sound = capture::MediaSound::open(video);
  if (!sound) return forward(sound);
  if (!*sound)
    return fail(ErrorCode::NotFound, text(video.string(),
                                          ": has no sound track; synchronise by --sync flash, or "
                                          "leave the camera out with --cameras"));
  const int rate = (*sound)->rate(), channels = (*sound)->channels();
  constexpr double kLongestHole = 60;  // s
  std::vector<float> all;
  std::optional<double> begin;
  for (;;) {
    if (is_cancelled(watch)) return cancelled();
    const Result<capture::MediaSound::Block> block = (*sound)->next();
    if (!block && block.error().code == ErrorCode::EndOfStream) break;
    if (!block)
      return fail(block.error().code, text(block.error().message,
                                           "; synchronise by --sync flash, or leave the "
                                           "camera out with --cameras"));
    const double time = seconds(block->time);
    if (!begin) begin = time;
    const double hole = time - *begin - static_cast<double>(all.size()) / rate;
    constexpr double kUnbroken = 0.04;  // s, of what containers with coarse times say
    if (hole > kLongestHole)
      return fail(ErrorCode::BadData, text(video.string(), ": its sound stops for ", hole,
                                           " s; synchronise by --sync flash, or cut the video"));
    if (hole > kUnbroken) all.resize(all.size() + static_cast<std::size_t>(hole * rate), 0.0F);
    for (std::size_t i = 0; i + static_cast<std::size_t>(channels) <= block->samples.size();
         i += static_cast<std::size_t>(channels))
      all.push_back(std::accumulate(block->samples.begin() + static_cast<std::ptrdiff_t>(i),
                                    block->samples.begin() + static_cast<std::ptrdiff_t>(i) + channels,
                                    0.0F) /
                    static_cast<float>(channels));
  }
  return sound_onsets(std::move(all), rate, begin.value_or(0));
}

Nanoseconds to_ns(double s) { return Nanoseconds{std::llround(s * 1e9)}; }

// The picture nearest to each instant; none is shown twice. `moved`: from the video's time to the take's.
SyncedVideos::Camera nearest(const std::vector<double>& times, double moved, int instants, double first,
                             double rate) {
  SyncedVideos::Camera camera;
  constexpr double kHalf = 0.5000001;
  std::size_t next = 0;
  std::optional<std::size_t> begin, end;
  for (int k = 0; k < instants; ++k) {
    const double wanted = first + k / rate;
    while (next + 1 < times.size() &&
           std::abs(times[next + 1] + moved - wanted) <= std::abs(times[next] + moved - wanted))
      ++next;
    const bool fits = next < times.size() && std::abs(times[next] + moved - wanted) <= kHalf / rate;
    camera.pictures.push_back(fits ? static_cast<int>(next) : -1);
    camera.times.push_back(Timestamp{} + to_ns(fits ? times[next] + moved : wanted));
    if (!fits) continue;
    if (!begin) begin = next;
    end = next++;
  }
  if (!begin) return camera;
  camera.sound = {.first = to_ns(times[*begin]),
                  .last = to_ns(times[*end]),
                  .take_first = Timestamp{} + to_ns(times[*begin] + moved),
                  .take_last = Timestamp{} + to_ns(times[*end] + moved)};
  return camera;
}

Result<SyncedVideos> instants_of(const std::vector<Survey>& surveys, const std::vector<OnsetShift>& shifts,
                                 const std::vector<std::string>& serials, std::optional<double> wanted_rate) {
  SyncedVideos out;
  out.frame_rate = wanted_rate.value_or(0);
  std::size_t last_begun = 0, first_ended = 0;
  const auto begins = [&](std::size_t c) { return surveys[c].times.front() - shifts[c].seconds; };
  const auto ends = [&](std::size_t c) { return surveys[c].times.back() - shifts[c].seconds; };
  for (std::size_t c = 0; c < surveys.size(); ++c) {
    if (!wanted_rate && (c == 0 || surveys[c].rate() < out.frame_rate)) out.frame_rate = surveys[c].rate();
    if (begins(c) > begins(last_begun)) last_begun = c;
    if (ends(c) < ends(first_ended)) first_ended = c;
    out.found.push_back({serials[c], shifts[c].seconds, shifts[c].events, shifts[c].spread});
  }
  const double length = ends(first_ended) - begins(last_begun);
  if (length < 0)
    return fail(ErrorCode::BadData,
                text("camera '", serials[first_ended], "' had ended when camera '", serials[last_begun],
                     "' began: there is no instant in which all run; leave one out with --cameras"));
  // Half an instant after the clock's 0, so that no picture was taken before it.
  const double first = 0.5 / out.frame_rate;
  const int instants = static_cast<int>(std::floor(length * out.frame_rate + 1e-6)) + 1;
  for (std::size_t c = 0; c < surveys.size(); ++c)
    out.cameras.push_back(nearest(surveys[c].times, first - begins(last_begun) - shifts[c].seconds, instants,
                                  first, out.frame_rate));
  return out;
}

}  // namespace

Result<SyncedVideos> sync_videos(const std::vector<CameraMedia>& media,
                                 const std::vector<std::string>& serials, SyncSign sign,
                                 std::optional<double> frame_rate, int threads, Progress* progress) {
  std::vector<std::optional<Result<Survey>>> surveyed(media.size());
  std::vector<Result<std::vector<Onset>>> onsets(media.size(), std::vector<Onset>());
  {
    ProgressPart part(progress, "synchronise", media.size());
    parallel_for(media.size(), threads, [&](std::size_t c) {
      surveyed[c] = survey(media[c], progress);
      if (*surveyed[c])
        onsets[c] = sign == SyncSign::Clap
                        ? claps_in(media[c].video, progress)
                        : brightness_onsets((*surveyed[c])->brightness, (*surveyed[c])->times);
      part.advance();
    });
  }
  std::vector<Survey> surveys;
  std::vector<std::vector<Onset>> trains;
  for (std::size_t c = 0; c < media.size(); ++c) {
    const Error* error = !*surveyed[c] ? &surveyed[c]->error() : !onsets[c] ? &onsets[c].error() : nullptr;
    if (error) return fail(error->code, text("camera '", serials[c], "': ", error->message));
    surveys.push_back(std::move(**surveyed[c]));
    trains.push_back(std::move(*onsets[c]));
  }
  const Result<std::vector<OnsetShift>> shifts =
      shifts_of(trains, serials, sign == SyncSign::Clap ? kClaps : kFlashes);
  if (!shifts) return forward(shifts);
  return instants_of(surveys, *shifts, serials, frame_rate);
}

Result<int> copy_synced(PictureStream& stream, const SyncedVideos::Camera& plan, std::size_t camera,
                        const Progress* watch, capture::TakeWriter& writer) {
  int at = -1, gaps = 0;
  Result<std::optional<Image>> picture = std::optional<Image>();
  for (std::size_t k = 0; k < plan.pictures.size(); ++k) {
    if (is_cancelled(watch)) return cancelled();
    Frame frame;
    FrameInfo info;
    info.camera = static_cast<int>(camera);
    info.sequence = k;
    info.exposure_start = plan.times[k];
    for (; at < plan.pictures[k]; ++at)
      if (picture = stream.next(); !picture) return forward(picture);
    if (plan.pictures[k] >= 0 && *picture) {
      frame = make_frame(info, **picture);
    } else {
      frame.info = info;
      frame.info.status = FrameStatus::Lost;
      ++gaps;
    }
    if (Result<void> ok = writer.write(frame); !ok) return forward(ok);
  }
  return gaps;
}

}  // namespace floatstage::pipeline
